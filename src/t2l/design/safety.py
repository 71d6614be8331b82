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
from t2l.hardware.nominal import respond
from t2l.hardware.plan import Setup
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor, Request
from t2l.robots.kinematics import ToolKinematics

SAFE = 0.8  # bound: of velocity and torque limits: the model is the one that is to be corrected
WORKSPACE_MARGIN_M = 0.02  # bound: likewise
# numerics: from one try to the next: at least, and at most where a motion is far beyond
SMALLER, MUCH_SMALLER = 0.8, 0.5
TRIES = 14  # numerics: down to 4 % of what the ranges leave, or less
LOOKS_HZ = 200.0  # numerics: at the simulated state: a joint at 10 Hz is seen 20 times a period


@dataclass(frozen=True)
class Safe:
    """Motions that keep the margins, and what was simulated of them.

    Attributes:
        peaks: for each motion the largest part that it uses of what is safe: of the room to the
            ends of the ranges, of velocities, of torques.
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
    left = list(enumerate(candidates))
    safe: dict[int, tuple[Candidate, float]] = {}
    for _ in range(TRIES):
        if not left:
            break
        used, peaks = _used(setup, model, inverse, [c for _, c in left], workspace)
        tried, left = left, []
        for (number, candidate), part, peak in zip(tried, used, peaks, strict=True):
            if (part <= 1.0).all():
                safe[number] = candidate, peak
                continue
            # a joint at rest may be driven by the others
            guilty = ~(part <= 1.0) & (candidate.amplitude_rad > 0)
            part = part if guilty.any() else np.full_like(part, part.max())
            smaller = np.clip(SMALLER / np.where(part > 0, part, np.inf), MUCH_SMALLER, SMALLER)
            left.append((number, candidate.scaled(np.where(part <= 1.0, 1.0, smaller))))
    found = [safe[number] for number in sorted(safe)]
    return Safe([c for c, _ in found], np.array([peak for _, peak in found]))


def _used(
    setup: Setup,
    model: Model,
    inverse: mujoco.MjModel,
    candidates: Sequence[Candidate],
    workspace: Workspace | None,
) -> tuple[np.ndarray, np.ndarray]:
    """How much of what is safe each joint uses, (n, njoint), and the most of a limit, (n,).

    More than 1 is not safe; infinite where a simulation ran away.
    """
    robot, motions = setup.robot, [c.motion(setup) for c in candidates]
    limits = {
        "q": position_bounds(robot, POSITION_MARGIN_RAD),
        "dq": _narrowed(velocity_bounds(robot)),
        "torque": _narrowed(torque_bounds(robot)),
    }
    used, peaks = [], []
    answers = zip(motions, _simulated(setup, model, motions), _nominal(setup, motions), strict=True)
    for motion, (q, dq), nominal in answers:
        rows = len(q) // len(motion.q_des)
        torque = motion.kp * (np.repeat(motion.q_des, rows, axis=0) - q) - motion.kd * dq
        steps = np.gradient(motion.q_des, 1 / motion.rate_hz, axis=0)
        needed = motion_torque(robot, motion.q_des, motion.rate_hz, inverse)
        values = (
            ("q", motion.q_des), ("q", q), ("dq", dq), ("dq", steps), ("torque", torque),
            ("torque", predicted_torque(motion, needed)),
        )  # fmt: skip
        part = np.max([nominal, *(_part(limits[key], value) for key, value in values)], axis=0)
        peaks.append(float(part.max()))
        if workspace and (part <= 1.0).all() and leaves(workspace, setup, q):
            part = np.full_like(part, 1.0 + np.finfo(float).eps)
        used.append(part)
    return np.array(used), np.array(peaks)


def _nominal(setup: Setup, motions: Sequence[Motion]) -> list[np.ndarray]:
    """How much of its limits each joint uses in the simulation that `t2l record` looks at.

    What is refused there is not safe here, whatever the model knows more.

    Args:
        motions: of one duration.
    """
    robot = setup.robot
    q_des, kp, kd = (
        np.stack([getattr(motion, key) for motion in motions]) for key in ("q_des", "kp", "kd")
    )
    found = respond(robot, setup.features, q_des, setup.command_rate_hz, kp, kd)
    limits = position_bounds(robot), velocity_bounds(robot), torque_bounds(robot)
    return [
        np.max([_part(bounds, values) for bounds, values in zip(limits, one, strict=True)], axis=0)
        for one in zip(found.q, found.dq, found.torque, strict=True)
    ]


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


def _part(bounds: Bounds, values: np.ndarray) -> np.ndarray:
    """Of each joint the largest distance from the middle of its bounds, over that of their ends."""
    known = np.isfinite(bounds.high - bounds.low)
    middle, half = np.zeros(len(known)), np.full(len(known), np.inf)
    middle[known] = (bounds.high[known] + bounds.low[known]) / 2
    half[known] = (bounds.high[known] - bounds.low[known]) / 2
    part = np.abs(values - middle).max(axis=0) / half
    # also of a joint without bounds
    return np.where(np.isfinite(values).all(axis=0), part, np.inf)


def leaves(workspace: Workspace, setup: Setup, q: np.ndarray) -> bool:
    """Whether the tool comes too close to the faces of a box, or beyond, at q (n, njoint)."""
    place = tool_places(setup, q)
    low = np.array(workspace.lower) + WORKSPACE_MARGIN_M
    high = np.array(workspace.upper) - WORKSPACE_MARGIN_M
    return bool(((place < low) | (place > high)).any())


def tool_places(setup: Setup, q: np.ndarray) -> np.ndarray:
    """Where the tool is at q (n, njoint), (n, 3) m in the frame of the base."""
    return ToolKinematics(setup.robot, len(q)).pose(q)[:, :3]
