"""From rollouts to one row a policy, and to one row a cell."""

from typing import TYPE_CHECKING, Any

from t2l.gains import Cell
from t2l.rl.problem import Choice
from t2l.rl.results import Evaluation

if TYPE_CHECKING:
    import pandas as pd

# of one policy, which its training names
POLICY = ["kp", "kd", "seed"]


def policy_row(
    rollouts: "pd.DataFrame",
    chosen: tuple[Cell, Choice],
    outcome: tuple[Evaluation, float],
) -> dict[str, Any]:
    """What a policy was trained with, what it came to in simulation, and on the robot.

    Errors are means over rollouts; rates and successes are shares of all of them.

    Args:
        rollouts: the policy's, as `t2l.transfer.errors.rollout_table` makes them.
        chosen, outcome: see `t2l.rl.results`.
    """
    (cell, choice), (evaluation, gain) = chosen, outcome
    return {
        "kp": cell.kp,
        "kd": cell.kd,
        "seed": int(rollouts.seed.iloc[0]),
        **{f"action_scale_{i}": scale for i, scale in enumerate(choice.action_scale)},
        **choice.reward_weights,
        "objective": evaluation.objective,
        # over the 100 episodes that judge a policy in its simulator
        "success_sim_100": evaluation.success,
        "feedback_gain": gain,
        "trajectory_error": rollouts.trajectory_error.mean(),
        "nn_error": rollouts.nn_error.mean(),
        "jitter_rate": rollouts.jitter_failure.mean(),
        "jitter_rate_sim": rollouts.jitter_failure_sim.mean(),
        "stopped_rate": (rollouts.stopped != "").mean(),
        "stopped_rate_sim": (rollouts.stopped_sim != "").mean(),
        "success_real": rollouts.success.mean(),
        "success_sim": rollouts.success_sim.mean(),
        "rollouts": len(rollouts),
    }


def over_seeds(policies: "pd.DataFrame") -> "pd.DataFrame":
    """One row a cell: the means over its policies."""
    return policies.groupby(["kp", "kd"], as_index=False).mean(numeric_only=True)


def best_and_worst(rollouts: "pd.DataFrame") -> dict[str, tuple[Cell, int, int, float]]:
    """The cells with the least and the greatest error, with seed, number and E of a median rollout.

    Args:
        rollouts: of one condition, columns kp, kd, seed, rollout, trajectory_error.
    """
    by_cell = rollouts.groupby(["kp", "kd"]).trajectory_error.mean()
    found = {}
    for word, gains in (("least error", by_cell.idxmin()), ("greatest error", by_cell.idxmax())):
        own = rollouts[(rollouts.kp == gains[0]) & (rollouts.kd == gains[1])]
        middle = own.sort_values("trajectory_error").iloc[len(own) // 2]
        found[word] = (
            Cell(*gains), int(middle.seed), int(middle.rollout), float(middle.trajectory_error)
        )  # fmt: skip
    return found
