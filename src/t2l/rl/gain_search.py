"""Gains and action scale searched together, for several objectives at once.

Each trial trains a policy in simulation under gains of its own. What it comes to are objectives
that pull in different ways: success, effort, jitter and, with a twin of the robot, the error of
transfer. So the answer is a front of trials, none of which another one beats in everything. Limits
of the robot, and a least success, are constraints. As chance chose the front too, each of its
trials is trained again from other seeds, and those policies report.
"""

import hashlib
import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import optuna
from optuna.trial import TrialState

from t2l.diagnose.recordings_and_model import read_recordings_and_model
from t2l.environment.ideal import ideal_plant
from t2l.errors import ConfigurationError
from t2l.gains import Cell
from t2l.identify.model import Model
from t2l.policies import Policy
from t2l.recordings.recording import CONTINUOUS
from t2l.rl.gain_table import AGAIN, gain_table
from t2l.rl.problem import Choice, Condition, Problem, scale_names
from t2l.rl.results import TOLERATED, Evaluation
from t2l.rl.settings import LOGARITHMIC, Search, Settings
from t2l.rl.side_by_side import Training, device_for, learn_and_judge
from t2l.rl.trials import open_study, requeue_abandoned
from t2l.rl.tuning import ask, at_once, choose, first_guess
from t2l.rl.twin import Machine, Twin
from t2l.sim.batch import MUJOCO
from t2l.tasks import Rewarded

# what is better the more, or the less there is of it
OBJECTIVES = {
    "success": "maximize", "effort": "minimize", "jitter_rad_s": "minimize",
    "transfer_error": "minimize",
}  # fmt: skip
TRANSFERRED = "transfer_error"
SUCCEEDS = "least_success"  # the constraint beside those that are limits
TWIN_EPISODES = 20  # statistics: pairs of episodes that an error of transfer is a mean of


@dataclass(frozen=True)
class GainSearch:
    """What is searched.

    Attributes:
        kp, kd, action_scale: bounds, all searched by their logarithms.
        trials: that a study is to have.
        startup: trials before the sampler judges by earlier ones.
        limits: names in `t2l.environment.limits.LIMITS` that constrain the search.
        least_success: share of episodes that a trial of the front needs.
        again: how often each trial of the front is trained again.
    """

    kp: tuple[float, float]
    kd: tuple[float, float]
    action_scale: tuple[float, float]
    trials: int
    startup: int
    limits: tuple[str, ...]
    least_success: float
    again: int

    @property
    def scales(self) -> Search:
        """The part of it about action scales."""
        return Search(
            self.trials, LOGARITHMIC, self.action_scale, {}, startup=self.startup, prune=False
        )


@dataclass(frozen=True, eq=False)
class GainProblem:
    """A task whose gains are searched.

    Attributes:
        rate_hz: of the physics that trains.
        machine: the loop of the robot, for which gains must be stable.
        twin: whether the machine is a model of the real robot, so that transfer can be judged.
    """

    condition: Condition
    rate_hz: float
    horizon_s: float
    machine: Machine
    twin: bool

    @cached_property
    def task(self) -> Rewarded:
        """The condition's."""
        return self.condition.make_task()

    @property
    def objectives(self) -> dict[str, str]:
        """Direction of each objective, by name."""
        return {k: v for k, v in OBJECTIVES.items() if self.twin or k != TRANSFERRED}

    def at(self, cell: Cell) -> Problem:
        """What is learned under the gains of a cell."""
        plant = ideal_plant(self.task, cell)
        return Problem(self.condition, cell, plant, self.rate_hz, self.horizon_s)

    def unstable(self, cell: Cell) -> str:
        """Why the robot's loop is not stable under the gains of a cell; nothing if it is."""
        robot = self.task.robot
        return self.machine.unstable(robot, *robot.gains(cell.kp, cell.kd))

    def study_name(self, search: GainSearch, settings: Settings, seed: int) -> str:
        """Of Optuna's study: a change of what a trial is makes another; more trials do not."""
        content = {
            "condition": asdict(self.condition), "rate_hz": self.rate_hz,
            "horizon_s": self.horizon_s, "machine": asdict(self.machine), "twin": self.twin,
            "search": asdict(search) | {"trials": None, "again": None},
            "settings": asdict(settings), "seed": seed,
        }  # fmt: skip
        text = json.dumps(content, sort_keys=True, default=str)
        return f"{self.condition.name}/gains/{hashlib.sha256(text.encode()).hexdigest()[:12]}"


def of_entry(
    entry: Mapping[str, Any],
    task: str,
    parameters: Mapping[str, Any],
    learning: Mapping[str, Any],
    machine: Machine | None = None,
) -> tuple[GainProblem, GainSearch, Settings]:
    """What a checked entry asks for.

    Args:
        entry: a `GainSearchEntry` of the configuration's models, as a dictionary.
        task: name of it.
        parameters: content of its file.
        learning: `reinforcement_learning` of a configuration, for what the entry does not say.
        machine: a twin of the robot, if there is one.
    """
    condition = Condition(
        name=task, task=task, policy_rate_hz=entry["policy_rate_hz"], randomisation=0.0,
        actions=entry["actions"], parameters=parameters,
    )  # fmt: skip
    robot = condition.make_task().robot.name
    own = machine or Machine(Model(robot), entry["control_rate_hz"], CONTINUOUS)
    problem = GainProblem(
        condition, entry["rate_hz"], entry["horizon_s"], own, twin=machine is not None
    )
    search = GainSearch(
        **{name: tuple(entry[name]) for name in ("kp", "kd", "action_scale", "limits")},
        **{name: entry[name] for name in ("trials", "startup", "least_success", "again")},
    )
    sizes = {name: entry[name] for name in ("environments", "updates", "evaluate_every")}
    others = {k: v for k, v in learning.items() if k != "horizon_s"}
    return problem, search, Settings(**{**others, **sizes, "enough": None})


def asked_for(
    entry: Mapping[str, Any],
    parameters: Mapping[str, Any],
    learning: Mapping[str, Any],
    storage: str,
    folder: Path,
) -> tuple[optuna.Study, GainProblem, GainSearch, Settings]:
    """What an entry of `learning.gain_searches` asks for, checked, and its study in a folder.

    Raises:
        ConfigurationError: see `check`, or the recordings are of another robot.
        T2LError: recordings or their model are wrong, or the storage cannot be used.
    """
    given = (entry, entry["task"], parameters, learning)
    problem, search, settings = of_entry(*given)
    if "recordings" in entry:
        model, recordings, _ = read_recordings_and_model(
            [Path(path) for path in entry["recordings"]], (), Path(entry["model"])
        )
        problem, *_ = of_entry(*given, Machine.of(model, recordings, problem.task.robot))
    check(problem, search, settings)
    name, directions = problem.study_name(search, settings, entry["seed"]), problem.objectives
    study = open_study(storage, folder / "trials.journal", name, list(directions.values()))
    return study, problem, search, settings


def check(problem: GainProblem, search: GainSearch, settings: Settings) -> None:
    """Find what would fail in every trial, before the first.

    Raises:
        ConfigurationError: a rate is not allowed, policies would never be judged, the softest
            gains are unstable already, or the twin cannot do the task.
        EffectError: an effect of the twin's model needs what no simulation has.
    """
    softest = Cell(search.kp[0], search.kd[0])
    if settings.evaluate_every > settings.updates:
        raise ConfigurationError(
            f"evaluate_every: found {settings.evaluate_every}; allowed: at most the updates, "
            f"{settings.updates}"
        )
    # what an environment refuses, such as rates that do not divide
    choice = Choice((search.action_scale[0],) * len(scale_names(problem.task.robot)))
    problem.at(softest).environments(choice, settings, 1, seed=0)
    if reason := problem.unstable(softest):
        raise ConfigurationError(f"gains: found {softest} as the lowest, where {reason}")
    if not problem.twin:
        return
    task = problem.task
    twin = _twin(problem, task, softest, 1)
    twin.begin(np.arange(1), task.sample_starts(np.random.default_rng(0), 1))
    twin.step(twin.q, 1)


def work(
    study: optuna.Study,
    problem: GainProblem,
    search: GainSearch,
    settings: Settings,
    seed: int,
    workers: int = 1,
    threads: int = 1,
    report: Callable[[str], None] = lambda line: None,
) -> None:
    """Run trials until `search.trials` have finished, or others are at work on the last.

    What an earlier process left unfinished is run again.

    Args:
        seed: of the sampler; that of training is in `settings`.
        workers: trials at once, side by side where a GPU trains them.
        report: takes a line a trial.
    """
    for number in requeue_abandoned(study):
        report(f"trial {number} was left unfinished and is run again")
    if not study.get_trials(deepcopy=False):
        middle = Cell(*(math.sqrt(low * high) for low, high in (search.kp, search.kd)))
        guess = first_guess(problem.at(middle), search.scales)
        study.enqueue_trial({"kp": middle.kp, "kd": middle.kd, **guess}, skip_if_exists=True)
    if device_for(problem.task) == MUJOCO:
        workers = 1
    while wanted := min(at_once(study, search.scales, workers), workers):
        asked = [_ask(study, problem, search, seed) for _ in range(wanted)]
        trainings = [_training(problem, cell, choice, settings) for _, cell, choice in asked]
        found = outcomes(problem, trainings, threads)
        for (trial, cell, choice), one in zip(asked, found, strict=True):
            report(_tell(study, problem, search, trial, cell, choice, one))


def confirm(
    study: optuna.Study,
    problem: GainProblem,
    search: GainSearch,
    settings: Settings,
    threads: int = 1,
    report: Callable[[str], None] = lambda line: None,
) -> None:
    """Train each trial of the front again, as often as is asked for and not done yet."""
    robot = problem.task.robot
    rows = gain_table(study, problem.objectives)
    for row in rows[rows.front].to_dict("records"):
        cell = Cell(row["kp"], row["kd"])
        choice = Choice(tuple(row[name] for name in scale_names(robot)))
        for k in range(1, 1 + search.again):
            key = f"{AGAIN}/{row['number']}/{k}"
            if key in study.user_attrs:
                continue
            own = settings.of_policy(problem.condition.name, cell, k)
            (found,) = outcomes(problem, [_training(problem, cell, choice, own)], threads)
            # a failure counts as one: what was chosen by chance shows so
            study.set_user_attr(key, {"error": found} if isinstance(found, str) else found)
            report(f"trial {row['number']} again, seed {k}: {_told(problem, found)}")


Outcome = dict[str, Any] | str


def outcomes(
    problem: GainProblem, trainings: Sequence[Training | str], threads: int = 1
) -> Iterator[Outcome]:
    """What trainings come to: objectives and rates by name, or why there is no policy."""
    real = [training for training in trainings if not isinstance(training, str)]
    each = iter(learn_and_judge(real, threads))
    for training in trainings:
        if isinstance(training, str):
            yield training
            continue
        trained, judged = next(each)
        if judged is None:
            yield str(trained)
            continue
        found = _numbers(judged)
        if problem.twin:
            found[TRANSFERRED] = transfer_error(problem, training, trained.policy, threads)
        yield found if all(map(math.isfinite, found.values())) else "it runs away on the twin"


def transfer_error(
    problem: GainProblem, training: Training, policy: Policy, threads: int = 1
) -> float:
    """E: mean over episodes, joints and time of (q_sim − q_twin)² + (q̇_sim − q̇_twin)².

    The study's error of transfer (section IV-C), at the instants at which the policy acts, from the
    same starts to the same goals; NaN if the twin runs away.
    """
    own, n, seed = training.problem, TWIN_EPISODES, training.settings.seed + 5
    task = own.task
    starts, goals = (
        sample(np.random.default_rng(seed), n) for sample in (task.sample_starts, task.sample_goals)
    )
    twin = _twin(problem, task, own.cell, n, threads)
    motions = []
    for rate_hz, simulator in ((own.rate_hz, None), (1 / twin.timestep_s, twin)):
        environments = replace(own, rate_hz=rate_hz).environments(
            training.choice, training.settings, n, seed, threads=threads, simulator=simulator
        )
        motions.append(_motion(policy, environments, starts, goals))
    sim, real = motions
    return float(((sim - real) ** 2).sum(axis=1).mean())


def _twin(problem: GainProblem, task: Any, cell: Cell, n: int, threads: int = 1) -> Twin:
    kp, kd = task.robot.gains(cell.kp, cell.kd)
    rate, longest_s = problem.condition.policy_rate_hz, problem.horizon_s
    return Twin(problem.machine, task, kp, kd, n, rate, longest_s, threads)


def _motion(policy: Policy, environments: Any, starts: np.ndarray, goals: np.ndarray) -> np.ndarray:
    """(ndecision, 2, n, njoint) q and q̇ when the policy acts."""
    observation, motion = environments.place(starts, goals), []
    for _ in range(environments.horizon):
        motion.append((environments.simulator.q.copy(), environments.simulator.dq.copy()))
        observation, *_ = environments.step(policy.action(observation))
    return np.array(motion)


def _numbers(found: Evaluation) -> dict[str, float]:
    return {
        "success": found.success, "effort": found.effort, "jitter_rad_s": found.jitter_rad_s,
        **found.rates,
    }  # fmt: skip


def _training(
    problem: GainProblem, cell: Cell, choice: Choice, settings: Settings
) -> Training | str:
    """What a trial trains, or why it is hopeless."""
    return problem.unstable(cell) or Training(problem.at(cell), choice, settings)


def _ask(
    study: optuna.Study, problem: GainProblem, search: GainSearch, seed: int
) -> tuple[optuna.Trial, Cell, Choice]:
    """A trial, and what it chose."""
    trial = ask(study, search.startup, seed)
    gains = [trial.suggest_float(n, *getattr(search, n), log=True) for n in ("kp", "kd")]
    choice = choose(trial, search.scales, problem.task.robot)
    return trial, Cell(*gains), choice


def _tell(
    study: optuna.Study,
    problem: GainProblem,
    search: GainSearch,
    trial: optuna.Trial,
    cell: Cell,
    choice: Choice,
    found: Outcome,
) -> str:
    """Take in how a trial went; a line that says it."""
    scales = ", ".join(f"{scale:.3g}" for scale in choice.action_scale)
    gains = f"Kp {cell.kp:.3g}, Kd {cell.kd:.3g}"
    line = f"trial {trial.number}: {gains}, action scales {scales} rad: {_told(problem, found)}"
    if isinstance(found, str):
        trial.set_user_attr("error", found)
        for name in (*search.limits, SUCCEEDS):
            trial.set_constraint(name, 1.0)  # as much as can be broken
        study.tell(trial, state=TrialState.PRUNED)
        return line
    for name, value in found.items():
        trial.set_user_attr(name, value)
    broken = broken_by(found, search)
    for name, by in broken.items():
        trial.set_constraint(name, by)
    study.tell(trial, [found[name] for name in problem.objectives])
    too_much = [name for name, by in broken.items() if by > 0]
    return f"{line}; breaks {', '.join(too_much)}" if too_much else line


def broken_by(found: Mapping[str, float], search: GainSearch) -> dict[str, float]:
    """By how much an outcome breaks each constraint, as a share of episodes; 0 or less if not."""
    limits = {name: found[name] - TOLERATED[name] for name in search.limits}
    return {**limits, SUCCEEDS: search.least_success - found["success"]}


def _told(problem: GainProblem, found: Outcome) -> str:
    if isinstance(found, str):
        return found
    return ", ".join(f"{name} {found[name]:.3g}" for name in problem.objectives)
