"""Motions made so small that the simulated robot keeps a margin to all of its limits."""

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from t2l.design.library import Candidate, recording
from t2l.hardware.guard import Workspace
from t2l.hardware.limits import (
    POSITION_MARGIN_RAD,
    Bounds,
    motion_torque,
    position_bounds,
    predicted_torque,
    torque_bounds,
    velocity_bounds,
)
from t2l.hardware.motion import Motion
from t2l.hardware.plan import Setup
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor, Request
from t2l.robots.kinematics import ToolKinematics

SAFE = 0.8  # of velocity and torque limits: the model is the one that is to be corrected
WORKSPACE_MARGIN_M = 0.02  # likewise
SMALLER = 0.8  # from one try to the next
TRIES = 14  # down to 4 % of what the ranges leave
LOOKS_HZ = 200.0  # at the simulated state: a joint at 10 Hz is seen 20 times a period


@dataclass(frozen=True)
class Safe:
    """Motions that keep the margins, and what was simulated of them.

    Attributes:
        peaks: for each motion the largest part of a limit that it uses: of the room to the ends of
            the ranges, of velocities, of torques.
    """

    candidates: list[Candidate]
    peaks: np.ndarray


def within_limits(
    setup: Setup,
    model: Model,
    candidates: Sequence[Candidate],
    workspace: Workspace | None = None,
) -> Safe:
    """Candidates as large as asked, or smaller; those that no size makes safe are left out.

    Args:
        model: the robot as far as it is known, with its effects.
        workspace: a box for the tool, in the frame of the robot's base.
    """
    inverse = setup.robot.spec(gravity_compensation=True).compile()
    if workspace and _leaves(workspace, setup, setup.start[None]):
        return Safe([], np.zeros(0))
    left = list(enumerate(candidates))
    safe: dict[int, tuple[Candidate, float]] = {}
    for _ in range(TRIES):
        if not left:
            break
        beyond, peaks = _beyond(setup, model, inverse, [c for _, c in left], workspace)
        tried, left = left, []
        for (number, candidate), out, peak in zip(tried, beyond, peaks, strict=True):
            if not out.any():
                safe[number] = candidate, peak
                continue
            # a joint at rest may be driven by the others
            guilty = out & (candidate.amplitude_rad > 0)
            which = guilty if guilty.any() else candidate.amplitude_rad > 0
            left.append((number, candidate.scaled(np.where(which, SMALLER, 1.0))))
    found = [safe[number] for number in sorted(safe)]
    return Safe([c for c, _ in found], np.array([peak for _, peak in found]))


def _beyond(
    setup: Setup,
    model: Model,
    inverse: mujoco.MjModel,
    candidates: Sequence[Candidate],
    workspace: Workspace | None,
) -> tuple[np.ndarray, np.ndarray]:
    """Which joints are beyond a margin, (n, njoint), and the largest part of a limit used, (n,)."""
    robot, motions = setup.robot, [c.motion(setup) for c in candidates]
    limits = {
        "q": position_bounds(robot, POSITION_MARGIN_RAD),
        "dq": _narrowed(velocity_bounds(robot)),
        "torque": _narrowed(torque_bounds(robot)),
    }
    beyond, peaks = [], []
    for motion, (q, dq) in zip(motions, _simulated(setup, model, motions), strict=True):
        rows = len(q) // len(motion.q_des)
        torque = motion.kp * (np.repeat(motion.q_des, rows, axis=0) - q) - motion.kd * dq
        steps = np.gradient(motion.q_des, 1 / motion.rate_hz, axis=0)
        needed = motion_torque(robot, motion.q_des, motion.rate_hz, inverse)
        values = (
            ("q", motion.q_des), ("q", q), ("dq", dq), ("dq", steps), ("torque", torque),
            ("torque", predicted_torque(motion, needed)),
        )  # fmt: skip
        out = np.any([limits[key].outside(value).any(axis=0) for key, value in values], axis=0)
        if workspace and not out.any():
            out |= _leaves(workspace, setup, q)
        beyond.append(out)
        peaks.append(max(_part(limits[key], value) for key, value in values))
    return np.array(beyond), np.array(peaks)


def _simulated(
    setup: Setup, model: Model, motions: Sequence[Motion]
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Position and velocity, (n, njoint) each, of every motion, at `LOOKS_HZ` or faster."""
    rows = max(1, round(LOOKS_HZ / setup.command_rate_hz))
    predictor = Predictor(model.robot, [recording(setup, motion, rows) for motion in motions])
    layout, u = model.vector(setup.robot.joints)
    (q,), (dq,) = predictor.predict([Request(layout, u[None])], velocity=True)
    samples = predictor.samples
    return list(zip(samples.by_row(q[0]), samples.by_row(dq[0]), strict=True))


def _narrowed(bounds: Bounds) -> Bounds:
    return Bounds(bounds.names, SAFE * bounds.low, SAFE * bounds.high, bounds.unit)


def _part(bounds: Bounds, values: np.ndarray) -> float:
    """The largest distance from the middle of the bounds, over that of their ends."""
    known = np.isfinite(bounds.high - bounds.low)
    if not known.any():
        return 0.0
    low, high = bounds.low[known], bounds.high[known]
    return float(np.max(np.abs(2 * values[:, known] - high - low) / (high - low)))


def _leaves(workspace: Workspace, setup: Setup, q: np.ndarray) -> bool:
    """Whether the tool comes too close to the faces of a box, or beyond, at q (n, njoint)."""
    place = ToolKinematics(setup.robot, len(q)).pose(q)[:, :3]
    low = np.array(workspace.lower) + WORKSPACE_MARGIN_M
    high = np.array(workspace.upper) - WORKSPACE_MARGIN_M
    return bool(((place < low) | (place > high)).any())
