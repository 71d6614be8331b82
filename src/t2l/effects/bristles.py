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
from t2l.sim.loop import each_tick, over_ticks
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
    batch, dofs, at = loop.batch, loop.dofs[joints], (..., rows, loop.columns(joints))
    give = loop.springs(rows, joints)
    passive, bias = batch.bind("qfrc_passive"), batch.bind("qfrc_bias")
    resolved = 1 / (batch.model.dof_invweight0[dofs] * batch.model.opt.timestep**2)
    sigma = np.minimum(stiffness, resolved)
    loop.bristles[at] += level(np.zeros_like(stiffness))
    state: dict[str, np.ndarray] = {}

    @over_ticks
    def add(tick, q, dq, torque):
        # at the tick: what bends them in the meantime is integrated here
        here, speed = loop.q[at], loop.dq[at]
        g = np.maximum(level(speed), LEAST)
        if not state:
            missing = each_tick(torque)[0][at] + passive[rows, dofs] - bias[rows, dofs]
            # what is measured of a log that begins at rest may seem to move
            start, dq_start = each_tick(here)[0], each_tick(speed)[0] * loop.moving[rows]
            least = each_tick(np.broadcast_to(g, here.shape))[0]
            bent = bent_at_start(missing, dq_start, least, sigma)
            most = least / np.maximum(sigma, LEAST)
            state.update(q=start, z=loop.held_at_start(rows, joints, bent, most, most))
        z, share = deflection(here, speed, state, g, sigma, loop.plant_period_s)
        torque[at] -= sigma * z
        give(torque, sigma * share, damping * share)

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
    """Deflection, rad, at a tick, and the share of the motion ahead that bends it.

    Args:
        q, dq, level: (…, k), or of ticks that follow each other (n, …, k).
        state: q and z, (…, k), of the tick before them.
    """
    several = q.reshape(-1, *np.shape(state["q"]))
    moved = np.diff(several, axis=0, prepend=state["q"][None]).reshape(q.shape)
    limit, left = (one.reshape(several.shape) for one in slipping(moved, level, sigma))
    now, bent = state["z"], np.empty_like(several)
    for i, end, share in zip(range(len(bent)), limit, left, strict=True):
        now = bent[i] = end + (now - end) * share
    state["q"], state["z"], z = several[-1], now, bent.reshape(q.shape)
    ahead = dq * period_s
    moves = np.abs(ahead) > LEAST
    share = (bent_by(ahead, z, level, sigma) - z) / np.where(moves, ahead, 1.0)
    return z, np.clip(np.where(moves, share, 1.0), 0.0, 1.0)


def bent_by(moved, z, level, sigma):
    """Deflection (…) rad after a motion in rad, from a deflection z."""
    limit, left = slipping(moved, level, sigma)
    return limit + (z - limit) * left


def slipping(moved, level, sigma):
    """Deflection, rad, to which a motion tends, and what is left of the way there after it."""
    limit = level * np.sign(moved) / np.maximum(sigma, LEAST)
    return limit, np.exp(-sigma * np.abs(moved) / level)
