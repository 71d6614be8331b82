"""Dry friction as bristles that bend before they slip, at the physics step.

    ż = q̇ − σ0 |q̇| z / g(q̇),   τ = −(σ0 z + σ1 ż)

Between two ticks z follows the motion exactly, were g constant,

    z → z_s + (z − z_s) e^(−σ0 |Δq| / g),   z_s = g sign(Δq) / σ0.

Within a tick the bristles are the spring and the damper that they are
on average over the motion ahead. MuJoCo steps both with the joint, the damper implicitly, so that a
stuck joint needs no smaller tick. No bristle is stiffer than the physics step resolves.
"""

from collections.abc import Callable

import numpy as np

from t2l.effects.effect import AT_REST_RAD_S
from t2l.sim.servo import ServoLoop

LEAST = 1e-12  # numerics: N·m and rad, in place of zero


def install_bristles(
    loop: ServoLoop,
    rows: slice,
    joints: np.ndarray,
    stiffness: np.ndarray,
    level: Callable[[np.ndarray], np.ndarray],
    damping: np.ndarray | float = 0.0,
) -> None:
    """Give `joints` bristles.

    Args:
        stiffness: σ0 (nrow, k), N·m/rad.
        level: g (nrow, k) in N·m from the velocity (nrow, k) in rad/s.
        damping: σ1, N·m·s/rad.
    """
    batch, ids, dofs = loop.batch, loop.ids[joints], loop.dofs[joints]
    qpos, at = loop.qpos[joints], (rows, loop.columns(joints))
    position, velocity = batch.qpos, batch.qvel
    spring, damper = batch.expand("jnt_stiffness"), batch.expand("dof_damping")
    rest = batch.expand("qpos_spring")
    passive, bias = batch.bind("qfrc_passive"), batch.bind("qfrc_bias")
    resolved = 1 / (batch.model.dof_invweight0[dofs] * batch.model.opt.timestep**2)
    sigma = np.minimum(stiffness, resolved)
    own, state = {}, {}

    def add(tick, q, dq, torque):
        # at the tick: what bends them in the meantime is integrated here
        here, speed = position[rows, qpos], velocity[rows, dofs]
        g = np.maximum(level(speed), LEAST)
        if tick == 0:
            # copies: what all other effects have written
            own.update(k=spring[rows, ids], d=damper[rows, dofs], rest=rest[rows, qpos])
            missing = torque[at] + passive[rows, dofs] - bias[rows, dofs]
            state.update(q=here, z=bent_at_start(missing, speed, g, sigma))
        z, share = deflection(here, speed, state, g, sigma, loop.plant_period_s)
        torque[at] -= sigma * z
        added = sigma * share
        total = np.maximum(own["k"] + added, LEAST)
        spring[rows, ids] = own["k"] + added
        rest[rows, qpos] = (own["k"] * own["rest"] + added * here) / total
        damper[rows, dofs] = own["d"] + damping * share

    loop.joint_torques.append(add)


def add_bristles(robot, joints, stiffness, level, damping):
    """Give an exported robot bristles of a stiffness, a level and a damping, (k,) each."""
    q, dq, state = robot.position[joints], robot.velocity[joints], robot.state
    level = np.maximum(level, LEAST)
    weight = robot.model.dof_invweight0[robot.dofs[joints]]
    sigma = np.minimum(stiffness, 1 / (weight * robot.period_s**2))
    if not state:
        missing = robot.motor + robot.torque + robot.passive - robot.load
        state.update(q=q, z=bent_at_start(missing[joints], dq, level, sigma))
    z, share = deflection(q, dq, state, level, sigma, robot.period_s)
    robot.torque[joints] -= sigma * z
    robot.stiffness[joints] += sigma * share
    robot.pull[joints] += sigma * share * q
    robot.damping[joints] += damping * share


def bent_at_start(missing, dq, level, sigma):
    """Deflection, rad, that holds a joint which lacks a torque; in motion that of slip."""
    bent = np.where(np.abs(dq) < AT_REST_RAD_S, missing, level * np.sign(dq))
    return np.clip(bent, -level, level) / np.maximum(sigma, LEAST)


def deflection(q, dq, state, level, sigma, period_s):
    """Deflection, rad, at a tick, and the share of the motion ahead that bends it."""
    z = bent_by(q - state["q"], state["z"], level, sigma)
    state["q"], state["z"] = q, z
    ahead = dq * period_s
    moves = np.abs(ahead) > LEAST
    share = (bent_by(ahead, z, level, sigma) - z) / np.where(moves, ahead, 1.0)
    return z, np.clip(np.where(moves, share, 1.0), 0.0, 1.0)


def bent_by(moved, z, level, sigma):
    """Deflection (…) rad after a motion in rad, from a deflection z."""
    limit = level * np.sign(moved) / np.maximum(sigma, LEAST)
    return limit + (z - limit) * np.exp(-sigma * np.abs(moved) / level)
