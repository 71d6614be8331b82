"""Tasks that are learned in simulation alone, under the gains of a cell as they are.

Whether there is a policy for a task at some gains is a question about simulation (the study's
section V-B): nothing is identified, and nothing is deployed. On a GPU where there is one.
"""

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from t2l.environment.ideal import ideal_plant
from t2l.gains import Cell
from t2l.policies import Policy
from t2l.rl.algorithm import Report, Trained
from t2l.rl.learn import EPISODES, judge
from t2l.rl.problem import Choice, Condition, Problem
from t2l.rl.settings import Search, Settings
from t2l.rl.side_by_side import Training, device_for, learn_side_by_side
from t2l.rl.trials import Best, best
from t2l.rl.unfinished import Unfinished
from t2l.sim.batch import MUJOCO
from t2l.tasks import Rewarded, make_task

if TYPE_CHECKING:
    import optuna
    import pandas as pd

COLUMNS = (
    "task", "kp", "kd", "seed", "episodes", "successes", "failed", "jitter", "steps", "seconds",
)  # fmt: skip

SHOWN_EPISODES = 20  # that a success and a failure are looked for in
SHOWN_COLUMNS = ("success", "time_s", "qpos")


def problem_of(
    entry: Mapping[str, Any], parameters: Mapping[str, Any], cell: Cell
) -> tuple[Problem, Choice | None]:
    """What is to be learned, and the action scales to learn it with, if they are known.

    Args:
        entry: of `learning.tasks` in a checked configuration.
        parameters: content of its task's file.
        cell: one of the entry's.

    Raises:
        ConfigurationError: the task's robot is not known or not installed.
    """
    condition = Condition(
        name=entry["task"], task=entry["task"], policy_rate_hz=entry["policy_rate_hz"],
        randomisation=0.0, actions=entry["actions"], parameters=parameters,
        action_scales=entry["action_scales"],
    )  # fmt: skip
    plant = ideal_plant(make_task(parameters), cell)
    problem = Problem(condition, cell, plant, entry["rate_hz"], entry["horizon_s"])
    return problem, condition.given(cell)


def depends_on(problem: Problem, choice: Choice, settings: Settings, seed: int) -> str:
    """All that a policy of `train_alone` depends on, but the version of t2l, as text."""
    content = [asdict(problem), asdict(choice), asdict(settings), seed, device_for(problem.task)]
    return json.dumps(content, sort_keys=True, default=np.ndarray.tolist)


def settings_of(section: Mapping[str, Any], entry: Mapping[str, Any]) -> Settings:
    """How an entry's policies are trained.

    Args:
        section: `reinforcement_learning` but `horizon_s`, for what the entry does not say.
    """
    names = ("environments", "updates", "evaluate_every")
    noise = ("observation_noise_rad", "observation_noise_rad_s")
    own = {name: entry[name] for name in (*names, *noise)}
    if "clip_actions" in entry:
        own["clip_actions"] = entry["clip_actions"]
    return replace(Settings(**section), enough=None, **own)


def search_of(section: Mapping[str, Any], task: Rewarded) -> Search:
    """What is searched for a task that is not deployed: success alone ranks its trials (App. E).

    Args:
        section: `tuning` of a checked configuration.
    """
    return replace(Search.from_section(section, task), solved_at=math.inf)


def search_scales(
    study: "optuna.Study",
    problem: Problem,
    search: Search,
    settings: Settings,
    seed: int,
    workers: int = 1,
    threads: int = 1,
    report: Callable[[str], None] = lambda line: None,
) -> Best:
    """Run trials until a study has enough, and the best of them; see `t2l.rl.tuning`.

    Args:
        workers: trials at once where a GPU trains them.

    Raises:
        TuningError: no trial was completed.
    """
    # it loads torch
    from t2l.rl.tuning import work, work_side_by_side

    if device_for(problem.task) == MUJOCO:
        work(study, problem, search, settings, seed, threads, report)
    else:
        studies = [(study, problem)]
        work_side_by_side(studies, search, settings, seed, workers, threads, report)
    return best(study, problem.task.robot, search.trials)


def train_alone(
    problem: Problem,
    choice: Choice,
    settings: Settings,
    seed: int,
    report: Report = lambda update, policy, evaluation: None,
    threads: int = 1,
    unfinished: Unfinished | None = None,
    episodes: int = EPISODES,
) -> tuple[Trained, dict[str, Any], "pd.DataFrame"]:
    """A policy, and how it does in episodes that neither trained nor chose it.

    It is judged on the processor, wherever it was trained: there physics is MuJoCo's.

    Args:
        seed: number of the policy, which its own seed is derived from.
        episodes: that judge it.
        unfinished: see `Training`.

    Returns:
        The policy as it was kept, its row of a table, columns `COLUMNS`, and episodes to show,
        columns `SHOWN_COLUMNS`.

    Raises:
        ConfigurationError: an action scale or a rate is not allowed.
        TrainingError: training left no policy that can act.
    """
    name, cell = problem.condition.name, problem.cell
    own = settings.of_policy(name, cell, seed)
    training = [Training(problem, choice, own, report, unfinished)]
    device = device_for(problem.task)
    # one policy on the processor is stable-baselines3's
    (trained,) = learn_side_by_side(training, threads, None if device == MUJOCO else device)
    if isinstance(trained, Exception):
        raise trained
    row = judged(training[0], trained, seed, threads, episodes)
    return trained, row, shown(problem, choice, own, trained.policy)


def judged(
    training: Training, trained: Trained, seed: int, threads: int = 1, episodes: int = EPISODES
) -> dict[str, Any]:
    """A row of `COLUMNS`: how the policy of a training does in fresh episodes.

    Args:
        seed, episodes: see `train_alone`.
    """
    problem, cell, policy = training.problem, training.problem.cell, trained.policy
    found = judge(problem, training.choice, training.settings, policy, threads, episodes)
    last = trained.history.iloc[-1]
    return {
        "task": problem.condition.name, "kp": cell.kp, "kd": cell.kd, "seed": seed,
        "episodes": episodes, "successes": round(found.success * episodes),
        "failed": found.failed, "jitter": found.rates["jitter"],
        "steps": int(last.steps), "seconds": float(last.seconds),
    }  # fmt: skip


def shown(problem: Problem, choice: Choice, settings: Settings, policy: Policy) -> "pd.DataFrame":
    """A success and a failure of a policy, as far as it has them, in episodes of their own.

    Returns:
        One row a step, columns `SHOWN_COLUMNS`.
    """
    import pandas as pd

    environments = problem.environments(choice, settings, SHOWN_EPISODES, settings.seed + 4)
    observation, qpos, ended = environments.reset(), [], {}
    for _ in range(environments.horizon):
        qpos.append(environments.simulator.batch.qpos.copy())
        observation, _, done, infos = environments.step(policy.action(observation))
        for i in np.flatnonzero(done):
            ended.setdefault(int(i), (infos[i]["success"], len(qpos)))
    picked = {success: (i, length) for i, (success, length) in reversed(ended.items())}
    tables = [
        pd.DataFrame(
            {
                "success": success,
                "time_s": np.arange(length) * environments.period_s,
                "qpos": [row[i] for row in qpos[:length]],
            },
            columns=list(SHOWN_COLUMNS),
        )
        for success, (i, length) in sorted(picked.items(), reverse=True)
    ]
    return pd.concat(tables, ignore_index=True)
