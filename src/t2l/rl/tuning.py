"""Tuning action scales, and reward weights, by trials that each train a policy.

A worker runs trials until the study has as many as are wanted; several workers, on one machine or
many, share a study. A trial tells what to train with; the policies that are deployed are trained
anew, from other seeds, so that no policy reports the luck that chose it.

Two spaces of the action scales α of a robot's groups of joints:

- `study`: α of the first group uniform between the bounds, of each other a uniform share of it, as
  on the study's page; nothing is guessed.
- `logarithmic`: each by its logarithm, and the first trial is `first_guess`.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import optuna
from optuna.pruners import BasePruner, MedianPruner, ThresholdPruner
from optuna.trial import FrozenTrial, TrialState

from t2l.policies import Policy
from t2l.rl.algorithm import Trained, TrainingEnded, TrainingError
from t2l.rl.learn import judge
from t2l.rl.problem import Choice, Problem, scale_names
from t2l.rl.results import Evaluation
from t2l.rl.settings import LOGARITHMIC, Search, Settings
from t2l.rl.side_by_side import Training, learn_alone, learn_and_judge
from t2l.rl.trials import FINISHED, alive, count, requeue_abandoned, sign
from t2l.robots import Robot
from t2l.seeds import seed_sequence

# of a first guess at action scales
CRUISE_RAD_S = 0.3
ACCELERATING, MOST = 0.05, 0.5

# an objective that only a policy which breaks the limits can have; with `solved_at`, a success
HOPELESS = 0.1


def first_guess(problem: Problem, search: Search) -> dict[str, float]:
    """Scales with which a full action moves every joint briskly in the identified simulator.

    It asks a joint for `ACCELERATING` of its torque limit on top of what damping and friction take
    at `CRUISE_RAD_S`, but for no more than `MOST` of the limit, and for no jump of torque that the
    limit of its rate forbids.
    """
    p, robot = problem.parameters, problem.task.robot
    limit = robot.torque_limit
    resistance = p["static_friction"] + (p["damping"] + p["viscous_friction"]) * CRUISE_RAD_S
    wanted = (ACCELERATING * limit + resistance) / p["stiffness"]
    most = np.minimum(MOST * limit, robot.torque_rate_limit / problem.rate_hz)
    stiffness, _ = robot.gains(problem.cell.kp, problem.cell.kd)
    scale = np.minimum(wanted, most / stiffness)
    names = scale_names(robot)
    scales = [scale[robot.scale_group == group].max() for group in range(len(names))]
    return dict(zip(names, np.clip(scales, *search.action_scale).tolist(), strict=True))


def work(
    study: optuna.Study,
    problem: Problem,
    search: Search,
    settings: Settings,
    seed: int,
    threads: int = 1,
    report: Callable[[str], None] = lambda line: None,
) -> None:
    """Run trials until `search.trials` have finished, or others are at work on the last.

    What an earlier process left unfinished is run again. An uninterrupted worker and one that was
    killed and started again run the same trials.

    Args:
        seed: of the sampler; that of training is in `settings`.
        report: takes a line a trial.
    """
    settings = _prepare(study, problem, search, settings, report)
    while count(study, *FINISHED) + busy(study) < search.trials:
        trial, training = _ask(study, problem, search, settings, seed)
        trained = learn_alone(training, threads)
        found = None
        if isinstance(trained, Trained):
            found = judge(problem, training.choice, settings, trained.policy, threads)
        report(_tell(study, trial, training, trained, found, search.solved_at))


def work_side_by_side(
    studies: Sequence[tuple[optuna.Study, Problem]],
    search: Search,
    settings: Settings,
    seed: int,
    workers: int = 1,
    threads: int = 1,
    report: Callable[[str], None] = lambda line: None,
) -> None:
    """As several `workers` for the studies of several cells, whose trials train side by side.

    The trials before the sampler judges by earlier ones need no other: all of them come at once.
    """
    for study, problem in studies:
        ready = _prepare(study, problem, search, settings, report)
    while True:
        asked = [
            (study, *_ask(study, problem, search, ready, seed))
            for study, problem in studies
            for _ in range(at_once(study, search, workers))
        ]
        if not asked:
            return
        outcomes = learn_and_judge([training for _, _, training in asked], threads)
        for each, (one, found) in zip(asked, outcomes, strict=True):
            report(_tell(*each, one, found, search.solved_at))


def _prepare(
    study: optuna.Study,
    problem: Problem,
    search: Search,
    settings: Settings,
    report: Callable[[str], None],
) -> Settings:
    """Make a study ready for more trials; the settings of each."""
    settings = replace(settings, updates=search.updates or settings.updates)
    for number in requeue_abandoned(study):
        report(f"trial {number} was left unfinished and is run again")
    if search.space == LOGARITHMIC and not study.get_trials(deepcopy=False):
        # weights that a guess leaves out are sampled
        study.enqueue_trial(first_guess(problem, search), skip_if_exists=True)
    study.pruner = (
        HopelessPruner(search.startup, settings.updates)
        if search.prune
        else optuna.pruners.NopPruner()
    )
    return settings


def busy(study: optuna.Study) -> int:
    """Trials that a process is at work on."""
    running = study.get_trials(deepcopy=False, states=(TrialState.RUNNING,))
    return sum(alive(trial) for trial in running)


def at_once(study: optuna.Study, search: Search, workers: int) -> int:
    """Trials that may be asked for before any of them is told."""
    begun = count(study, *FINISHED) + busy(study)
    return min(max(workers, search.startup - begun), search.trials - begun)


def ask(study: optuna.Study, startup: int, seed: int) -> optuna.Trial:
    """A new trial of this process; what it chooses depends on the seed and the trials before alone.

    Args:
        startup: trials at random, before the sampler judges by earlier ones.
    """
    # so each trial has a sampler of its own
    state = seed_sequence(seed, "sampler", count(study, *FINISHED), busy(study)).generate_state(1)
    study.sampler = optuna.samplers.TPESampler(n_startup_trials=startup, seed=int(state[0]))
    trial = study.ask()
    sign(trial)
    return trial


def _ask(
    study: optuna.Study, problem: Problem, search: Search, settings: Settings, seed: int
) -> tuple[optuna.Trial, Training]:
    """A trial, and the training that it is."""
    trial = ask(study, search.startup, seed)
    choice = choose(trial, search, problem.task.robot)

    def follow(update: int, policy: Policy, found: Evaluation) -> None:
        sign(trial)
        trial.report(found.value(search.solved_at), update)
        if trial.should_prune():
            _note(trial, found)
            raise TrainingEnded

    return trial, Training(problem, choice, settings, follow)


def _tell(
    study: optuna.Study,
    trial: optuna.Trial,
    training: Training,
    trained: Trained | TrainingError | TrainingEnded,
    found: Evaluation | None,
    solved_at: float | None,
) -> str:
    """Take in how a trial went; a line that says it."""
    if isinstance(trained, TrainingEnded):
        study.tell(trial, state=TrialState.PRUNED)
        return _line(study, trial, training.choice)
    if isinstance(trained, TrainingError):
        trial.set_user_attr("error", str(trained))
        # hopeless, and the sampler takes it for the worst of all
        study.tell(trial, state=TrialState.PRUNED)
        return f"{_line(study, trial, training.choice)}: {trained}"
    _note(trial, found)
    trial.set_user_attr("steps", int(trained.history.steps.iloc[-1]))
    trial.set_user_attr("seconds", float(trained.history.seconds.iloc[-1]))
    study.tell(trial, found.value(solved_at))
    return _line(study, trial, training.choice)


def choose(trial: optuna.Trial, search: Search, robot: Robot) -> Choice:
    """What a trial suggests, its action scales kept as the trial's attributes too."""
    low, high = search.action_scale
    names = scale_names(robot)
    if search.space == LOGARITHMIC:
        scales = [trial.suggest_float(name, low, high, log=True) for name in names]
    else:
        first, *others = names
        base = trial.suggest_float(first, low, high)
        shares = [trial.suggest_float(f"{name}_share", 0.0, 1.0) for name in others]
        # a share of 0 would take a group of joints out of action
        scales = [base, *(max(base * share, 1e-9) for share in shares)]
    for name, scale in zip(names, scales, strict=True):
        trial.set_user_attr(name, scale)
    weights = {
        name: trial.suggest_float(name, *bounds, log=True)
        for name, bounds in search.reward_weights.items()
    }
    return Choice(tuple(scales), weights)


def _note(trial: optuna.Trial, found: Evaluation) -> None:
    for name, value in {"success": found.success, **found.rates}.items():
        trial.set_user_attr(name, value)


def _line(study: optuna.Study, trial: optuna.Trial, choice: Choice) -> str:
    frozen = study.get_trials(deepcopy=False)[trial.number]
    scales = ", ".join(f"{scale:.3g}" for scale in choice.action_scale)
    value = "pruned" if frozen.state == TrialState.PRUNED else f"objective {frozen.value:.3f}"
    return f"trial {trial.number}: action scales {scales} rad: {value}"


class HopelessPruner(BasePruner):
    """Ends what is worse than the median, and from half-way on what is below `HOPELESS`.

    Where most trials fail, the median fails too. Nothing is ended for the second reason before a
    trial is complete, so that a study always has a policy.
    """

    def __init__(self, startup: int, updates: int):
        """Judge trials of so many updates, by the median once `startup` are complete."""
        self._median = MedianPruner(startup, n_warmup_steps=updates // 4)
        self._floor = ThresholdPruner(lower=HOPELESS, n_warmup_steps=updates // 2)

    def prune(self, study: optuna.Study, trial: FrozenTrial) -> bool:
        """Whether to end this trial; see `BasePruner.prune`."""
        if self._floor.prune(study, trial) and count(study, TrialState.COMPLETE):
            return True
        return self._median.prune(study, trial)
