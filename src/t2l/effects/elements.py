"""Maxwell-slip elements side by side: springs that each slip at a radius of their own.

    τ = −Σ_k F_k z_k / r_k,   ż_k = q̇ within |z_k| ≤ r_k

Between two ticks z_k follows the motion exactly. Within a tick the elements are the spring that
they are on average over the motion ahead, which MuJoCo steps with the joint, so that a stuck joint
needs no smaller tick. No element is stiffer than the physics step resolves.
"""

import numpy as np

from t2l.effects.effect import AT_REST_RAD_S
from t2l.sim.loop import each_tick, over_ticks
from t2l.sim.servo import ServoLoop

LEAST = 1e-12  # numerics: N·m and rad, in place of zero


def install_elements(
    loop: ServoLoop, rows: slice, joints: np.ndarray, torque: np.ndarray, radii: np.ndarray
) -> None:
    """Give `joints` elements.

    Args:
        torque: N·m at which each slips, (nrow, k, n).
        radii: rad likewise.
    """
    batch, dofs, at = loop.batch, loop.dofs[joints], (..., rows, loop.columns(joints))
    give = loop.springs(rows, joints)
    passive, bias = batch.bind("qfrc_passive"), batch.bind("qfrc_bias")
    stiffness, radii = resolved(
        torque, radii, batch.model.dof_invweight0[dofs], batch.model.opt.timestep
    )
    loop.bristles[at] += torque.sum(axis=-1)
    state: dict[str, np.ndarray] = {}

    @over_ticks
    def add(tick, q, dq, total):
        here, speed = loop.q[at], loop.dq[at]
        if not state:
            missing = each_tick(total)[0][at] + passive[rows, dofs] - bias[rows, dofs]
            # what is measured of a log that begins at rest may seem to move
            start, dq_start = each_tick(here)[0], each_tick(speed)[0] * loop.moving[rows]
            way, most = way_at_start(missing, dq_start, torque, radii), radii.max(axis=-1)
            way = loop.held_at_start(rows, joints, way, most, most)
            state.update(q=start, z=stretched(way, dq_start, radii))
        z, share = stretch(here, speed, state, radii, loop.plant_period_s)
        total[at] -= (stiffness * z).sum(axis=-1)
        give(total, (stiffness * share).sum(axis=-1), 0.0)

    loop.joint_torques.append(add)


def add_elements(robot, joints, torque, radii):
    """Give an exported robot elements of a torque and a radius, (k, n) each."""
    q, dq, state = robot.position[joints], robot.velocity[joints], robot.state
    weight = robot.model.dof_invweight0[robot.dofs[joints]]
    stiffness, radii = resolved(torque, radii, weight, robot.period_s)
    if not state:
        missing = robot.motor + robot.torque + robot.passive - robot.load
        way = way_at_start(missing[joints], dq, torque, radii)
        state.update(q=q, z=stretched(way, dq, radii))
    z, share = stretch(q, dq, state, radii, robot.period_s)
    robot.torque[joints] -= (stiffness * z).sum(axis=-1)
    spring = (stiffness * share).sum(axis=-1)
    robot.stiffness[joints] += spring
    robot.pull[joints] += spring * q


def resolved(torque, radii, invweight, period_s):
    """N·m/rad and rad (…, k, n) of elements that slip at a torque: none too stiff for a step."""
    most = 1 / (invweight * period_s**2)[:, None]
    radii = np.maximum(radii, LEAST)
    stiffness = np.minimum(torque / radii, most)
    return stiffness, np.maximum(radii, torque / most)


def stretch(q, dq, state, radii, period_s):
    """Stretch, rad, at a tick, and the share of the motion ahead that stretches further.

    Args:
        q, dq: (…, k), or of ticks that follow each other (n, …, k).
        radii: (…, k, e).
        state: q (…, k) and z (…, k, e) of the tick before them.

    Returns:
        As `q`, with an axis more of e.
    """
    several = q.reshape(-1, *np.shape(state["q"]))
    moved = np.diff(several, axis=0, prepend=state["q"][None])
    now, z = state["z"], np.empty((*several.shape, np.shape(radii)[-1]))
    for i, by in enumerate(moved):
        now = z[i] = np.minimum(np.maximum(now + by[..., None], -radii), radii)
    state["q"], state["z"], z = several[-1], now, z.reshape(*q.shape, -1)
    ahead = (dq * period_s)[..., None]
    further = np.minimum(np.maximum(z + ahead, -radii), radii) - z
    moves = np.abs(ahead) > LEAST
    return z, np.where(moves, further / np.where(moves, ahead, 1.0), 1.0)


def way_at_start(missing, dq, torque, radii):
    """Rad (…, k) at which elements are where a log begins, see `stretched`.

    At rest they hold a joint which lacks a torque (…, k), in N·m; in motion all slip.
    """
    at = np.concatenate([np.zeros_like(radii[..., :1]), np.sort(radii, axis=-1)], axis=-1)
    # (…, k, e + 1) N·m once they came so far
    force = np.sum(
        torque[..., None, :] * np.minimum(at[..., None] / radii[..., None, :], 1.0), axis=-1
    )
    needed = np.abs(missing)[..., None]
    above = np.minimum((force < needed).sum(axis=-1), at.shape[-1] - 1)[..., None]
    below = np.maximum(above - 1, 0)
    f0, f1 = (np.take_along_axis(force, i, axis=-1) for i in (below, above))
    x0, x1 = (np.take_along_axis(at, i, axis=-1) for i in (below, above))
    part = np.clip((needed - f0) / np.maximum(f1 - f0, LEAST), 0.0, 1.0)
    held = np.sign(missing) * (x0 + part * (x1 - x0))[..., 0]
    return np.where(np.abs(dq) < AT_REST_RAD_S, held, np.sign(dq) * at[..., -1])


def stretched(way, dq, radii):
    """Stretch (…, k, e), rad, of elements where a log begins.

    A joint at rest came a way (…, k) from where none was stretched. A joint in motion turned where
    all had slipped back, and came since then the way, from minus the largest radius to it, twice.
    """
    way, dq, most = way[..., None], dq[..., None], radii.max(axis=-1, keepdims=True)
    at_rest = np.sign(way) * np.minimum(np.abs(way), radii)
    side = np.sign(dq)
    since = side * (np.minimum(most + side * way, 2 * radii) - radii)
    return np.where(np.abs(dq) < AT_REST_RAD_S, at_rest, since)
