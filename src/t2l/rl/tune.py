"""Tuning action scales, and reward weights, by trials that each train a policy.

A worker runs trials until the study has as many as are wanted; several workers, on one machine or
many, share a study. The policy of every trial is kept beside the study, in Optuna's artifact
store.
"""

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import optuna
from optuna.artifacts import FileSystemArtifactStore, upload_artifact
from optuna.trial import TrialState

from t2l.artefacts import write_table
from t2l.errors import writing
from t2l.policies import Policy, checkpoint
from t2l.rl.algorithm import TrainingError
from t2l.rl.choice import Choice
from t2l.rl.constraints import Evaluation
from t2l.rl.evaluate import evaluate
from t2l.rl.outcome import SCALES, sort_by_files
from t2l.rl.problem import Problem
from t2l.rl.pruning import HopelessPruner
from t2l.rl.registry import ALGORITHMS
from t2l.rl.settings import Search, Settings
from t2l.rl.trials import FINISHED, POLICY, TRAINING, alive, count, requeue_abandoned, sign
from t2l.seeds import seed_sequence

if TYPE_CHECKING:
    import pandas as pd

EPISODES = 100  # that judge a trial's best policy, the study's number
SELECTING_EPISODES = 50  # that choose a trial's best policy

# of a first guess at action scales
CRUISE_RAD_S = 0.3
ACCELERATING, MOST = 0.05, 0.5


def first_guess(problem: Problem, search: Search) -> dict[str, float]:
    """Scales with which a full action moves every joint briskly in the identified simulator.

    It asks a joint for `ACCELERATING` of its torque limit on top of what damping and friction take
    at `CRUISE_RAD_S`, but for no more than `MOST` of the limit.
    """
    p, robot = problem.parameters, problem.task.robot
    limit = robot.torque_limit
    resistance = p["static_friction"] + (p["damping"] + p["viscous_friction"]) * CRUISE_RAD_S
    wanted = (ACCELERATING * limit + resistance) / p["stiffness"]
    scale = np.minimum(wanted, MOST * limit / problem.cell.kp)
    scales = [scale[part].max() for part in (robot.proximal, ~robot.proximal)]
    return dict(zip(SCALES, np.clip(scales, *search.action_scale).tolist(), strict=True))


def work(
    study: optuna.Study,
    store: Path | str,
    problem: Problem,
    search: Search,
    settings: Settings,
    seed: int,
    threads: int = 1,
    report: Callable[[str], None] = lambda line: None,
) -> None:
    """Run trials until `search.trials` have finished, or others are at work on the last.

    What an earlier process left unfinished is run again, and so is a trial whose files can no
    longer be read. An uninterrupted worker and one that was killed and started again run the same
    trials.

    Args:
        store: folder for the trials' policies and training histories.
        seed: of the sampler; that of training is in `settings`.
        report: takes a line a trial.
    """
    with writing(store):
        Path(store).mkdir(parents=True, exist_ok=True)
    for number in requeue_abandoned(study):
        report(f"trial {number} was left unfinished and is run again")
    _, broken = sort_by_files(study, store)
    missing = search.trials - (count(study, *FINISHED) - len(broken))
    for trial, complaint in broken[: max(0, missing)]:
        study.enqueue_trial(trial.params, skip_if_exists=False)
        report(f"trial {trial.number} is run again: {complaint}")
    if not study.get_trials(deepcopy=False):
        # weights that a guess leaves out are sampled
        study.enqueue_trial(first_guess(problem, search), skip_if_exists=True)
    study.pruner = HopelessPruner(search.startup, settings.updates)
    wanted = search.trials + len(broken)
    while (done := count(study, *FINISHED)) + (busy := _busy(study)) < wanted:
        # a sampler of its own for each trial: its choice depends on the trials before alone
        state = seed_sequence(seed, "sampler", done, busy).generate_state(1)
        study.sampler = optuna.samplers.TPESampler(
            n_startup_trials=search.startup, seed=int(state[0])
        )
        report(_run(study, Path(store), problem, search, settings, threads))


def _busy(study: optuna.Study) -> int:
    running = study.get_trials(deepcopy=False, states=(TrialState.RUNNING,))
    return sum(alive(trial) for trial in running)


def _run(
    study: optuna.Study,
    store: Path,
    problem: Problem,
    search: Search,
    settings: Settings,
    threads: int,
) -> str:
    """One trial; a line that says how it went."""
    trial = study.ask()
    sign(trial)
    choice = _choose(trial, search)

    def follow(update: int, found: Evaluation) -> None:
        sign(trial)
        trial.report(found.objective, update)
        if trial.should_prune():
            _note(trial, found)
            raise optuna.TrialPruned

    seed = settings.seed
    try:
        trained = ALGORITHMS.find(settings.algorithm)().train(
            problem.environments(choice, settings.environments, seed, True, threads),
            problem.environments(choice, SELECTING_EPISODES, seed + 1, threads=threads),
            settings,
            follow,
            threads,
        )
    except optuna.TrialPruned:
        study.tell(trial, state=TrialState.PRUNED)
        return _line(study, trial, choice)
    except TrainingError as error:
        trial.set_user_attr("error", str(error))
        # hopeless, and the sampler takes it for the worst of all
        study.tell(trial, state=TrialState.PRUNED)
        return f"{_line(study, trial, choice)}: {error}"
    found = evaluate(
        trained.policy, problem.environments(choice, EPISODES, seed + 2, threads=threads)
    )
    _note(trial, found)
    trial.set_user_attr("steps", int(trained.history.steps.iloc[-1]))
    trial.set_user_attr("seconds", float(trained.history.seconds.iloc[-1]))
    _keep(trial, store, trained.policy, trained.history)
    study.tell(trial, found.objective)
    return _line(study, trial, choice)


def _choose(trial: optuna.Trial, search: Search) -> Choice:
    low, high = search.action_scale
    scales = tuple(trial.suggest_float(name, low, high, log=True) for name in SCALES)
    weights = {
        name: trial.suggest_float(name, *bounds, log=True)
        for name, bounds in search.reward_weights.items()
    }
    return Choice(scales, weights)


def _note(trial: optuna.Trial, found: Evaluation) -> None:
    for name, value in {"success": found.success, **found.rates}.items():
        trial.set_user_attr(name, value)


def _keep(
    trial: optuna.Trial,
    store: Path,
    policy: Policy,
    history: "pd.DataFrame",
) -> None:
    files = FileSystemArtifactStore(base_path=str(store))
    with tempfile.TemporaryDirectory() as folder:
        checkpoint.save(policy, Path(folder, POLICY))
        write_table(history, Path(folder, TRAINING))
        for name in (POLICY, TRAINING):
            key = upload_artifact(
                artifact_store=files, file_path=str(Path(folder, name)), study_or_trial=trial
            )  # fmt: skip
            trial.set_user_attr(name, key)


def _line(study: optuna.Study, trial: optuna.Trial, choice: Choice) -> str:
    frozen = study.get_trials(deepcopy=False)[trial.number]
    scales = ", ".join(f"{scale:.3g}" for scale in choice.action_scale)
    value = "pruned" if frozen.state == TrialState.PRUNED else f"objective {frozen.value:.3f}"
    return f"trial {trial.number}: action scales {scales} rad: {value}"
