"""What reaching pays, by the name that a task's file gives under `reward`.

- `progress`: the project's own; it pays for coming closer at once, so that few updates suffice.
- `isaaclab`: the terms of IsaacLab's template environment of reaching, whose weights the study's
  tasks are derived from (App. E): the penalties of velocity and of changing actions are 50 and 2
  times weaker in proportion to distance than in `progress`. Their weights are those that the
  template's curriculum ends with, after 4500 of the study's 24 000 steps.
"""

from collections.abc import Mapping

from t2l.sim.arrays import Array, namespace

PROGRESS, ISAACLAB = "progress", "isaaclab"

JOINT_WEIGHTS: Mapping[str, Mapping[str, float]] = {
    PROGRESS: {"distance": 0.4, "near": 1.0, "progress": 2.0, "velocity": 0.1, "change": 0.02},
    ISAACLAB: {"distance": 0.2, "fine": 0.1, "velocity": 1e-3, "change": 5e-3},
}
TOOL_WEIGHTS: Mapping[str, Mapping[str, float]] = {
    PROGRESS: {
        "position": 4.0, "orientation": 1.0, "near": 1.0, "progress": 1.0,
        "velocity": 0.1, "change": 0.02,
    },
    ISAACLAB: {
        "position": 0.2, "fine": 0.1, "orientation": 0.1, "velocity": 1e-3, "change": 5e-3,
    },
}  # fmt: skip

# of the template's term for the last of the way, m; here rad too, for joints
FINE = 0.1


def penalties(weights: Mapping[str, float], dq: Array, change: Array) -> Array:
    """Of moving fast and of actions that change, (n,); dq and change are (n, k)."""
    return weights["velocity"] * (dq**2).sum(axis=1) + weights["change"] * (change**2).sum(axis=1)


def fine(weights: Mapping[str, float], away: Array) -> Array:
    """The template's reward for the last of the way, for distances (n,)."""
    return weights["fine"] * (1 - namespace(away).tanh(away / FINE))
