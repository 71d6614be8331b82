"""A hand that is led to points: what a task's success is tried out with."""

import mujoco
import numpy as np

from t2l.environment.vector import make_vector
from t2l.gains import Cell

STIFF = Cell(512, 24)
SCALE = 0.3
RATE_HZ = 50.0
PERIOD_S = 1 / RATE_HZ


def scene(task, n, **of_environment):
    """Stiff arms at a task, each with a start and a goal of its own."""
    return make_vector(
        task, STIFF, (SCALE,) * len(task.robot.scale_groups), n, **of_environment
    ).environment


def towards(environment, points, opened, approach=(0.0, 0.0, -1.0), across=None):
    """The action that leads each tool to its point (n, 3) m, its z along `approach`.

    Args:
        opened: whether grippers are.
        across: where the tool's y points; anywhere without.
    """
    task, q = environment.task, environment.simulator.q
    model, data, site = task.model, mujoco.MjData(task.model), int(task.tool_sites[0])
    jacobian, action = np.empty((6, model.nv)), np.zeros((len(q), len(environment.action_names)))
    for i, point in enumerate(points):
        data.qpos[task.arm_qpos] = q[i]
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_jacSite(model, data, jacobian[:3], jacobian[3:], site)
        away = point - data.site_xpos[site]
        away = away / max(1.0, np.linalg.norm(away) / 0.12)
        axes = data.site_xmat[site].reshape(3, 3)
        turn = np.cross(axes[:, 2], approach)
        if across is not None:
            turn += np.cross(axes[:, 1], across)
        own = jacobian[:, task.arm_dofs]
        dq = own.T @ np.linalg.solve(own @ own.T + 1e-4 * np.eye(6), 6 * np.r_[away, turn])
        # three periods ahead of what a stiff arm lags behind
        action[i, : len(dq)] = np.clip(3 * dq / (RATE_HZ * SCALE), -1, 1)
    action[:, q.shape[1] :] = 1.0 if opened else -1.0
    return action


def play(environment, script):
    """Episodes of a script, which says from the time in s and what is measured where to go.

    Returns:
        How they ended, and their rewards (nstep, n).
    """

    def action(step):
        measured = environment.task.measure(environment.simulator.batch, environment._goal)
        points, opened, *turned = script(step / RATE_HZ, measured, environment._goal)
        return towards(environment, points, opened, *turned)

    environment.begin()
    return until_they_end(environment, action)


def until_they_end(environment, action):
    """How episodes that have begun end under the action of each step, and their rewards."""
    paid = []
    for step in range(environment.horizon):
        _, reward, ended = environment.advance(action(step))
        paid.append(reward)
        if ended.ids.size:
            return ended, np.array(paid)
    raise AssertionError("the episodes did not end")


def lead(task, starts, goals, targets, shake_rad=0.0, follows=True):
    """How episodes end whose joints are led to targets (n, njoint) rad.

    Args:
        shake_rad: how far commands go to and fro, five times a second.
        follows: whether the arm is led; else it is commanded to be where it is.
    """
    environment = scene(task, len(starts), horizon_s=4.0)
    environment.place(starts, goals)
    for step in range(environment.horizon):
        to_and_fro = shake_rad if step % 10 < 5 else -shake_rad
        ahead = (targets + to_and_fro - environment.simulator.q) / SCALE
        ended = environment.advance(np.clip(ahead, -1, 1) if follows else 0 * ahead)[2]
    return ended
