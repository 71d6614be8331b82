"""Stiffness over training: a policy is pushed whenever it is evaluated."""

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from t2l.policies import Policy
from t2l.rl.registry import ALGORITHMS
from t2l.rl.results import Evaluation
from t2l.rl.settings import Settings
from t2l.seeds import generator
from t2l.study.decoupling.pairing import POLICY_RATE_HZ, Pairing
from t2l.study.decoupling.stiffness import Probe, Yielding, measure
from t2l.tasks.disturbance import directions

if TYPE_CHECKING:
    import pandas as pd

    from t2l.rl.environments import Environments

JUDGED = 50  # episodes of an evaluation
COLUMNS = (
    "update", "direction", "stiffness_n_m", "passive_n_m", "drift", "swing", "success", "reward",
)  # fmt: skip


def make_probe(section: Mapping[str, Any], seed: int) -> Probe:
    """The forces that a `decoupling` section asks for; the same seed gives the same directions."""
    draw = generator(seed, "decoupling", "directions")
    force = section["force_n"] * directions(draw, section["directions"])
    return Probe(force, section["hold_s"])


def passive(
    pairing: Pairing,
    name: str,
    parameters: Mapping[str, Any],
    probe: Probe,
    settings: Settings,
) -> Yielding:
    """What the bare controller comes to, commanded to hold the pose."""
    at_home = {"kind": "joint_delta", "reference": "home"}
    environments = _probed(pairing, name, parameters, probe, settings, 1.0, **at_home)
    still = np.zeros((environments.num_envs, len(environments.task.robot.joints)))
    return measure(environments, lambda observation: still, probe)


def train(
    pairing: Pairing,
    name: str,
    parameters: Mapping[str, Any],
    probe: Probe,
    settings: Settings,
    horizon_s: float,
    torque_share: float,
    threads: int = 1,
) -> "tuple[pd.DataFrame, Policy]":
    """Train a pairing over the whole length of training.

    Args:
        name, parameters: of the task, and the content of its file.

    Returns:
        One row an evaluation and direction, columns `COLUMNS`; the policy that was evaluated last.
    """
    import pandas as pd

    problem = pairing.problem(name, parameters, horizon_s)
    choice = pairing.choice(problem.task, torque_share)
    probed = _probed(pairing, name, parameters, probe, settings, torque_share)
    found: list[pd.DataFrame] = []
    policies: list[Policy] = []

    def follow(update: int, policy: Policy, evaluation: Evaluation) -> None:
        policies[:] = [policy]
        yielding = measure(probed, policy.action, probe)
        found.append(
            pd.DataFrame(
                {
                    "update": update,
                    "direction": np.arange(len(probe.force)),
                    "stiffness_n_m": yielding.stiffness_n_m,
                    "drift": yielding.drift,
                    "swing": yielding.swing,
                }
            )
        )

    trained = ALGORITHMS.find(settings.algorithm)().train(
        problem.environments(choice, settings, settings.environments, settings.seed, True, threads),
        problem.environments(choice, settings, JUDGED, settings.seed + 1, threads=threads),
        # no success rate ends it
        replace(settings, enough=None),
        follow,
        threads,
    )
    bare = passive(pairing, name, parameters, probe, settings).stiffness_n_m
    table = pd.concat(found, ignore_index=True)
    table["passive_n_m"] = bare[table.direction]
    history = trained.history[["update", "success", "reward"]]
    return table.merge(history, on="update")[list(COLUMNS)], policies[0]


def _probed(
    pairing: Pairing,
    name: str,
    parameters: Mapping[str, Any],
    probe: Probe,
    settings: Settings,
    torque_share: float,
    **actions: Any,
) -> "Environments":
    """Two environments a force, with episodes that outlast it."""
    problem = pairing.problem(name, parameters, probe.duration_s + 1 / POLICY_RATE_HZ, **actions)
    choice = pairing.choice(problem.task, torque_share)
    return problem.environments(choice, settings, 2 * len(probe.force), 0)
