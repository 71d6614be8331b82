"""What reaching pays, by the name that a task's file gives under `reward`.

- `progress`: the project's own; it pays for coming closer at once, so that few updates suffice.
- `isaaclab`: the terms of IsaacLab's template environment of reaching, whose weights the study's
  tasks are derived from (App. E): the penalties of velocity and of changing actions are 50 and 2
  times weaker in proportion to distance than in `progress`. Their weights are those that the
  template's curriculum ends with, after 4500 of the study's 24 000 steps.

`at.now` is what is left to do, in rad of every joint, or of the tool's pose.
"""

from collections.abc import Mapping

from t2l.sim.arrays import Array, namespace
from t2l.tasks.terms import Moment, RewardTerm, action_change, minus, nearness, norm, speed

PROGRESS, ISAACLAB = "progress", "isaaclab"

# of the template's term for the last of the way, m; here rad too, for joints
FINE = 0.1


def sizes(pose: Array) -> tuple[Array, Array]:
    """Distances in m and angles in rad, (n,) each, of what is left of poses (n, 6)."""
    return norm(pose[:, :3]), norm(pose[:, 3:])


def fine(away: Array) -> Array:
    """The template's reward for the last of the way, for distances (n,)."""
    return nearness(away, FINE)


def joint_path(at: Moment) -> Array:
    """Σ |error| of the joints, rad."""
    return namespace(at.now).abs(at.now).sum(axis=1)


def joints_near(at: Moment) -> Array:
    """How many joints are at their goals, softly, as a share."""
    xp, near = namespace(at.now), at.task.tolerance_rad / 2
    return xp.exp(-((at.now / near) ** 2)).mean(axis=1)


def joint_progress(at: Moment) -> Array:
    """The rate at which a potential of what remains falls, rad/s.

    It credits an action at once and moves no optimum (Ng, Harada and Russell, 1999).
    """
    xp, near = namespace(at.now), at.task.tolerance_rad / 2
    return (xp.tanh(at.now / near) * (at.before - at.now)).sum(axis=1) / at.period_s


def pose_near(at: Moment) -> Array:
    """Whether position and orientation are within their tolerances, softly, a half each."""
    away, turned = sizes(at.now)
    xp, task = namespace(away), at.task
    at_position = xp.exp(-((away / task.position_tolerance_m) ** 2))
    return (at_position + xp.exp(-((turned / task.orientation_tolerance_rad) ** 2))) / 2


def pose_progress(at: Moment) -> Array:
    """The rate at which distance and angle fall, weighed as they are."""
    (was_away, was_turned), (away, turned) = sizes(at.before), sizes(at.now)
    w = at.task.weights
    fallen = w["position"] * (was_away - away) + w["orientation"] * (was_turned - turned)
    return fallen / at.period_s


_OWN = "t2l"
_TEMPLATE = "IsaacLab, manager-based reach environment"

JOINT_REWARDS: Mapping[str, tuple[RewardTerm, ...]] = {
    PROGRESS: (
        RewardTerm("distance", 0.4, minus(joint_path), _OWN),
        RewardTerm("near", 1.0, joints_near, _OWN),
        RewardTerm("progress", 2.0, joint_progress, _OWN),
        RewardTerm("velocity", 0.1, minus(speed), _OWN),
        RewardTerm("change", 0.02, minus(action_change), _OWN),
    ),
    ISAACLAB: (
        RewardTerm("distance", 0.2, lambda at: -norm(at.now), _TEMPLATE),
        RewardTerm("fine", 0.1, lambda at: fine(norm(at.now)), _TEMPLATE),
        RewardTerm("velocity", 1e-3, minus(speed), _TEMPLATE),
        RewardTerm("change", 5e-3, minus(action_change), _TEMPLATE),
    ),
}
TOOL_REWARDS: Mapping[str, tuple[RewardTerm, ...]] = {
    PROGRESS: (
        RewardTerm("position", 4.0, lambda at: -sizes(at.now)[0], _OWN),
        RewardTerm("orientation", 1.0, lambda at: -sizes(at.now)[1], _OWN),
        RewardTerm("near", 1.0, pose_near, _OWN),
        RewardTerm("progress", 1.0, pose_progress, _OWN),
        RewardTerm("velocity", 0.1, minus(speed), _OWN),
        RewardTerm("change", 0.02, minus(action_change), _OWN),
    ),
    ISAACLAB: (
        RewardTerm("position", 0.2, lambda at: -sizes(at.now)[0], _TEMPLATE),
        RewardTerm("fine", 0.1, lambda at: fine(sizes(at.now)[0]), _TEMPLATE),
        RewardTerm("orientation", 0.1, lambda at: -sizes(at.now)[1], _TEMPLATE),
        RewardTerm("velocity", 1e-3, minus(speed), _TEMPLATE),
        RewardTerm("change", 5e-3, minus(action_change), _TEMPLATE),
    ),
}
