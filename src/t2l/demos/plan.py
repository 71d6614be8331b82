"""How a batch of demonstrations is to go: every tool's motion through its waypoints."""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from scipy.spatial.transform import Rotation

from t2l.sim.controllers.arm_dynamics import ArmDynamics
from t2l.tasks import Demonstrated
from t2l.tasks.waypoints import Motion, Waypoint, motion_through, padded


@dataclass(frozen=True)
class Plan:
    """Motions of n demonstrations, each followed by rest to the length of the longest.

    Attributes:
        motions: one an arm, whose arrays have (n, steps) before their own shape.
        gripper: (n, steps, ngripper) commanded.
        lengths: (n,) steps of each before that rest.
    """

    motions: list[Motion]
    gripper: np.ndarray
    lengths: np.ndarray


def planned(
    task: Demonstrated,
    arms: Sequence[ArmDynamics],
    starts: np.ndarray,
    timestep_s: float,
    rng: np.random.Generator,
) -> Plan:
    """One way to solve the task from each of `starts` (n, nq), where the arms now are."""
    waypoints = [task.waypoints(rng, qpos) for qpos in starts]
    motions = [
        [
            motion_through(start, legs[i], timestep_s)
            for start, legs in zip(_tool_waypoints(arm), waypoints, strict=True)
        ]
        for i, arm in enumerate(arms)
    ]
    lengths = np.max([[len(motion.gripper) for motion in of_arm] for of_arm in motions], axis=0)
    steps = int(lengths.max())
    stacked = [_stack([padded(each, steps) for each in of_arm]) for of_arm in motions]
    gripper = [
        motion.gripper
        for motion, group in zip(stacked, task.robot.groups, strict=True)
        if group.gripper
    ]
    return Plan(stacked, np.stack(gripper, axis=2), lengths)


def _tool_waypoints(arm: ArmDynamics) -> list[Waypoint]:
    """Where the tool of each simulation is now."""
    poses = zip(arm.position.copy(), arm.rotation.copy(), strict=True)
    return [Waypoint(p, Rotation.from_matrix(r), 0.0, 0.0) for p, r in poses]


def _stack(motions: Sequence[Motion]) -> Motion:
    return Motion(
        **{
            field.name: np.stack([getattr(m, field.name) for m in motions])
            for field in fields(Motion)
        }
    )
