import mujoco
import numpy as np
import pytest
import yaml

from t2l.rl.evaluate import evaluate
from t2l.study.decoupling.pairing import Pairing
from t2l.study.decoupling.stiffness import Probe, measure
from t2l.study.decoupling.training import make_probe, passive, train
from t2l.tasks.disturbance import directions
from tests.defaults import TASKS, learning, shipped

FILE = yaml.safe_load((TASKS / "pose_hold.yaml").read_text())
HOME = {"kind": "joint_delta", "reference": "home"}
SOFT = Pairing("soft", 64.0, 24.0, HOME, 0.01, 0.0)
# so small that the arm is linear
GENTLE = Probe(0.05 * directions(np.random.default_rng(0), 16), hold_s=6.0)


def tool_jacobian():
    """(3, njoint) of the tool at home, m/rad."""
    task = shipped("pose_hold")
    data = mujoco.MjData(task.model)
    data.qpos[:] = task.robot.home
    mujoco.mj_forward(task.model, data)
    jacobian = np.empty((3, task.model.nv))
    mujoco.mj_jacSite(task.model, data, jacobian, None, int(task.tool_sites[0]))
    return jacobian


def exact(pairing, force):
    """K_eff of the bare controller, by Δx = J Kp⁻¹ Jᵀ F."""
    jacobian = tool_jacobian()
    moved = np.linalg.norm(force @ jacobian @ jacobian.T / pairing.kp, axis=1)
    return np.linalg.norm(force, axis=1) / moved


def probed(pairing, probe):
    """Environments that a probe pushes, and the action scale of each joint."""
    problem = pairing.problem("pose_hold", FILE, probe.duration_s + 0.02)
    choice = pairing.choice(problem.task, 0.4)
    environments = problem.environments(choice, learning(), 2 * len(probe.force), 0)
    return environments, environments.actions.scale


def test_the_bare_controller_is_as_stiff_as_its_gains_say():
    found = passive(SOFT, "pose_hold", FILE, GENTLE, learning())
    np.testing.assert_allclose(found.stiffness_n_m, exact(SOFT, GENTLE.force), rtol=0.01)
    assert found.drift.max() < 0.01
    assert found.swing.max() < 0.01


@pytest.mark.parametrize(("kp", "kd"), [(16.0, 8.0), (512.0, 24.0)])
@pytest.mark.parametrize("hertz", [0.5, 0.7, 1.3, 4.0])
def test_a_swing_that_does_not_answer_the_push_leaves_the_stiffness(kp, kd, hertz):
    """The command swings the tool three times as far as the push moves it."""
    pairing = Pairing("bare", kp, kd, HOME, 0.01, 0.0)
    # as long as in the study that sweeps weights
    probe = Probe(GENTLE.force, hold_s=4.0)
    environments, scale = probed(pairing, probe)
    away = np.median(0.05 / exact(pairing, probe.force))
    jacobian = tool_jacobian()
    command = 3 * away * np.sqrt(2) * jacobian.T[:, 0] / (jacobian @ jacobian.T)[0, 0]
    time_s = 0.0

    def swing(observation):
        nonlocal time_s
        time_s += environments.period_s
        one = np.sin(2 * np.pi * hertz * time_s) * command / scale
        return np.tile(one, (len(observation), 1))

    found = measure(environments, swing, probe)
    np.testing.assert_allclose(found.stiffness_n_m, exact(pairing, probe.force), rtol=0.1)
    assert found.drift.max() < 0.1
    # a soft controller lets little of it through
    assert found.swing.min() > (1 if kp > 16 else 0.05)


@pytest.mark.parametrize(("kp", "kd", "held"), [(512, 24, True), (16, 8, False)])
def test_a_pose_is_held_by_what_stays_near_it_though_pushes_move_it(kp, kd, held):
    """The bare controller, which is soft or stiff enough; pushes go on to an episode's end."""
    pairing = Pairing("bare", kp, kd, HOME, 0.01, 0.0)
    problem = pairing.problem("pose_hold", FILE, 4.0)
    environments = problem.environments(pairing.choice(problem.task, 0.4), learning(), 50, 1)

    class Still:
        def action(self, observation):
            return np.zeros((len(observation), 7))

    found = evaluate(Still(), environments)
    assert (found.success == 1) == held
    # at rest it is not
    assert found.rates["jitter"] > 0.3


def test_a_policy_that_pulls_back_adds_its_own_stiffness():
    """With q_des = g + k (g − q), the torque is (1 + k) Kp (g − q)."""
    environments, scale = probed(SOFT, GENTLE)

    def pull_back(observation):
        return 2.0 * observation[:, 14:21] / scale

    found = measure(environments, pull_back, GENTLE).stiffness_n_m
    bare = passive(SOFT, "pose_hold", FILE, GENTLE, learning()).stiffness_n_m
    np.testing.assert_allclose(found, 3 * bare, rtol=0.01)


def test_a_robot_that_moves_without_a_force_is_not_taken_for_a_soft_one():
    environments, _ = probed(SOFT, GENTLE)
    action = np.zeros((environments.num_envs, 7))

    def wander(observation):
        action[:, 0] += 1e-4
        return action

    found = measure(environments, wander, GENTLE).stiffness_n_m
    bare = passive(SOFT, "pose_hold", FILE, GENTLE, learning()).stiffness_n_m
    np.testing.assert_allclose(found, bare, rtol=0.1)


def test_what_moves_away_under_a_push_is_not_steady():
    environments, scale = probed(SOFT, GENTLE)

    def give_way(observation):
        # the command follows the joint, so nothing holds it but damping
        return -observation[:, 14:21] / scale

    assert measure(environments, give_way, GENTLE).drift.min() > 0.1


def test_a_full_action_asks_for_the_same_torque_whatever_the_gain():
    task = shipped("pose_hold")
    for kp in (16.0, 512.0):
        scale = Pairing("any", kp, 8.0, HOME, 0.01, 0.0).choice(task, 0.5).action_scale
        np.testing.assert_allclose(np.array(scale) * kp, [43.5, 6.0])


@pytest.mark.parametrize("reference", ["measured", "commanded"])
def test_a_training_is_pushed_at_every_evaluation_and_repeats_itself(reference):
    pairing = Pairing("p", 64.0, 24.0, HOME | {"reference": reference}, 1.0, 0.01)
    probe = make_probe({"force_n": 5.0, "directions": 4, "hold_s": 0.5}, 0)
    settings = learning(environments=8, updates=2, evaluate_every=1, seed=1)
    table, policy = train(pairing, "pose_hold", FILE, probe, settings, 1.0, 0.3)
    assert table.groupby("update").size().to_dict() == {1: 4, 2: 4}
    assert (table.stiffness_n_m > 0).all()
    assert table.passive_n_m.nunique() == 4
    again, _ = train(pairing, "pose_hold", FILE, probe, settings, 1.0, 0.3)
    np.testing.assert_array_equal(table.to_numpy(), again.to_numpy())
    # what actions are relative to is seen
    assert policy.observation_size == (35 if reference == "commanded" else 28)
