"""Hysteresis as elements that give elastically up to a radius and then slip.

    τ = −Σ_k w_k z_k / r_k,  ż_k = q̇ within |z_k| ≤ r_k

Source: Prandtl and Ishlinskii's model; Visintin, Differential models of hysteresis, 1994, section
III.6.
"""

import numpy as np

from t2l.effects.effect import AT_REST_RAD_S
from t2l.effects.law import Law
from t2l.sim.servo import ServoLoop

TINY = 1e-12  # numerics: N·m, in place of zero


def install_yielding(
    loop: ServoLoop, rows: slice, law: Law, radii: np.ndarray, weights: np.ndarray
) -> None:
    """Add elastic-plastic elements of `radii` (k,) with weights (nrow, k)."""
    joint = loop.joints.index(law.joint)
    dof = loop.dofs[joint]
    passive, bias = loop.batch.bind("qfrc_passive"), loop.batch.bind("qfrc_bias")
    anchors: list[np.ndarray] = []

    def add(tick, q, dq, torque):
        here = q[rows, joint][:, None]
        if not anchors:
            missing = torque[rows, joint] + passive[rows, dof] - bias[rows, dof]
            # what is measured of a log that begins at rest may seem to move
            moving = dq[rows, joint] * loop.moving[rows, 0]
            way = way_to_start(missing, moving, radii, weights)[:, None]
            way = loop.held_at_start(rows, np.array([joint]), way, radii[-1], radii[-1])
            anchors.append(here - stretched(way, radii))
        stretch = np.minimum(np.maximum(here - anchors[0], -radii), radii)
        anchors[0] = here - stretch
        torque[rows, joint] -= (weights * stretch / radii).sum(axis=1)

    loop.joint_torques.append(add)


def learned_hysteresis(robot, joints, values):
    """Add elastic-plastic elements that remember."""
    q, radii, joint = robot.angle[joints[0]], values["radii"], joints[0]
    if "anchors" not in robot.state:
        missing = robot.motor + robot.torque + robot.passive - robot.load
        speed = robot.velocity[joint]
        held = stretched_at_start(missing[joint], speed, radii, values["weights"])
        robot.state["anchors"] = q - held
    anchors = robot.state["anchors"]
    stretch = np.clip(q - anchors, -radii, radii)
    robot.state["anchors"] = q - stretch
    robot.torque[joints] -= np.sum(values["weights"] * stretch / radii)


def stretched_at_start(missing, dq, radii, weights):
    """Stretch (…, k), rad, that holds a joint which lacks a torque (…); in motion that of slip."""
    return stretched(way_to_start(missing, dq, radii, weights)[..., None], radii)


def stretched(way, radii):
    """Stretch (…, k), rad, after a way (…, 1) in rad from where nothing was stretched."""
    return np.sign(way) * np.minimum(np.abs(way), radii)


def largest(radii, weights):
    """N·m (…, 1) that elements hold at most, and rad (…, 1) of motion that leave little of it."""
    total = np.abs(weights).sum(axis=-1, keepdims=True)
    return total, (np.abs(weights) * radii).sum(axis=-1, keepdims=True) / np.maximum(total, TINY)


def way_to_start(missing, dq, radii, weights):
    """Way (…) in rad to where elements hold a joint which lacks a torque (…); in motion to slip."""
    at = np.append(0.0, radii)
    # (…, k + 1) N·m once it came so far
    force = np.sum(weights[..., None, :] * np.minimum(at[:, None], radii) / radii, axis=-1)
    needed = np.where(np.abs(dq) < AT_REST_RAD_S, np.abs(missing), np.inf)[..., None]
    above = np.minimum((force < needed).sum(axis=-1), len(radii))[..., None]
    below = np.maximum(above - 1, 0)
    f0, f1 = (np.take_along_axis(force, i, axis=-1) for i in (below, above))
    part = np.clip((needed - f0) / np.maximum(f1 - f0, TINY), 0.0, 1.0)
    distance = at[below] + part * (at[above] - at[below])
    sign = np.where(np.abs(dq) < AT_REST_RAD_S, np.sign(missing), np.sign(dq))
    return sign * distance[..., 0]
