"""Identification and reinforcement learning: steps a second, and time to succeed."""

import os

os.environ.setdefault("GOMP_SPINCOUNT", "20000")  # as the workflow does

import time
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from unittest.mock import patch

import numpy as np
import pandas as pd
import torch
from stable_baselines3.common.vec_env import SubprocVecEnv

from benchmarks.gymnasium_reach import GymnasiumReach
from benchmarks.scene import configuration, task_file
from t2l.gains import Cell
from t2l.hardware import open_backend
from t2l.hardware.identification_motion import identification_motion
from t2l.identify import actuators as identification
from t2l.rl.hyperparameters import REACH
from t2l.rl.learn import PROGRESS_EPISODES
from t2l.rl.ppo import make_model
from t2l.rl.problem import Choice, Condition, Problem
from t2l.rl.registry import ALGORITHMS
from t2l.rl.results import Evaluation
from t2l.rl.settings import Search, Settings
from t2l.rl.side_by_side import Training, device_for, learn_alone, learn_side_by_side
from t2l.rl.tuning import first_guess
from t2l.seeds import seed_sequence
from t2l.sim.batch import MUJOCO

CORES = len(os.sched_getaffinity(0))
CENTRE = Cell(128, 8)
CORNERS = [Cell(kp, kd) for kd in (1, 24) for kp in (16, 512)]
CONFIGURATION = configuration()
LEARNING = CONFIGURATION["reinforcement_learning"]
HORIZON_S = LEARNING.pop("horizon_s")
CONDITION = Condition(
    "joint_reach", "joint_reach", policy_rate_hz=50.0, randomisation=0.0,
    actions={"kind": "joint_delta"}, parameters=task_file("joint_reach"),
)  # fmt: skip
SEARCH = Search.from_section(CONFIGURATION["tuning"], CONDITION.make_task())
ENVIRONMENTS = LEARNING["environments"]
SETTINGS = Settings(**LEARNING)
PROCESSES_ENVIRONMENTS = 16  # of the rival
REPEATS = 5
TOGETHER = 8

Row = tuple[str, str, str, str]


def run() -> pd.DataFrame:
    """Each row is printed as it comes."""
    torch.set_num_threads(CORES)
    rows, parameters = [], {}
    for part in (
        identify_all,
        environment_steps,
        training_steps,
        trials_side_by_side,
        one_batch_of_trainings,
        time_to_succeed,
    ):
        for row in part(parameters):
            print(" | ".join(row), flush=True)
            rows.append(row)
    print()
    return pd.DataFrame(rows, columns=["what", "measured", "bound or baseline", "ratio"])


def identify_all(parameters: dict) -> Iterator[Row]:
    """Every corner and the centre as the default configuration identifies them."""
    settings = identification.Settings(**CONFIGURATION["identification"])
    robot = CONDITION.make_task().robot
    for cell in (CENTRE, *CORNERS):
        motion = identification_motion(robot, cell, **CONFIGURATION["recordings"])
        with open_backend({"backend": "virtual"}, robot) as arm:
            recording = arm.record(motion)
        seed = int(seed_sequence(0, "identify", cell.name).generate_state(1)[0])
        physics = _Stopwatch()
        began = time.perf_counter()
        with physics.around(identification.Simulator, "simulate"):
            found = identification.identify(recording, settings, seed, CORES, lambda *_: None)
        seconds = time.perf_counter() - began
        parameters[cell] = found.parameters
        share = f"{seconds:.0f} s, {100 * physics.seconds / seconds:.0f} % of it physics"
        yield (
            f"identification of {cell.name}, 200 iterations",
            share,
            "30 s",
            f"{seconds / 30:.2f}",
        )


def environment_steps(parameters: dict) -> Iterator[Row]:
    """Random actions through the VecEnv, and the same batch stepped barely, in turn."""
    environments, _ = _made(parameters, CENTRE)
    environments.reset()
    draw = np.random.default_rng(0)
    shape = (50, ENVIRONMENTS, *environments.action_space.shape)
    actions = draw.uniform(-1, 1, shape).astype(np.float32)
    simulator = environments.simulator

    def through(count: int = 50) -> None:
        for i in range(count):
            environments.step(actions[i])

    def bare(count: int = 50) -> None:
        for i in range(count):
            simulator.batch.ctrl[:] = simulator.q + environments.actions.scale * actions[i]
            simulator.batch.step(nstep=environments.nstep)

    through()
    vectorised, barely = [], []
    for _ in range(REPEATS):
        vectorised.append(_rate(through, 50 * ENVIRONMENTS))
        barely.append(_rate(bare, 50 * ENVIRONMENTS))
        environments.reset()
    ours, best = np.median(vectorised), np.median(barely)
    yield (
        f"VecEnv of {ENVIRONMENTS} arms, random actions", _per_second(ours),
        f"bare `Batch.step`, {_per_second(best)}", f"{ours / best:.2f}",
    )  # fmt: skip


def training_steps(parameters: dict) -> Iterator[Row]:
    """PPO on one batch, and on a gymnasium environment under SubprocVecEnv."""
    environments, choice = _made(parameters, CENTRE)
    rival = SubprocVecEnv(
        [
            _Maker(_problem(parameters, CENTRE), choice, seed)
            for seed in range(PROCESSES_ENVIRONMENTS)
        ]
    )
    try:
        rates = {}
        for name, made in (("batch", environments), ("processes", rival)):
            ppo = make_model(made, 42)
            steps = REACH.rollout_steps * made.num_envs
            ppo.learn(2 * steps, log_interval=None)
            rates[name] = np.median(
                [
                    _rate(lambda p=ppo, n=steps: p.learn(4 * n, log_interval=None), 4 * steps)
                    for _ in range(REPEATS)
                ]
            )
    finally:
        rival.close()
    yield (
        "PPO training, Joint-Reach", _per_second(rates["batch"]), "40 k steps/s",
        f"{rates['batch'] / 40e3:.2f}",
    )  # fmt: skip
    yield (
        "… beside gymnasium", _per_second(rates["batch"]),
        f"{PROCESSES_ENVIRONMENTS} environments under SubprocVecEnv, "
        f"{_per_second(rates['processes'])}",
        f"{rates['batch'] / rates['processes']:.0f}",
    )  # fmt: skip


def trials_side_by_side(parameters: dict) -> Iterator[Row]:
    """A training on each core at once, as the workflow runs trials of tuning."""
    context = get_context("spawn")
    ready = context.Barrier(CORES)
    problem = _problem(parameters, CENTRE)
    choice = Choice(tuple(first_guess(problem, SEARCH).values()))
    with ProcessPoolExecutor(CORES, context, _share, (ready,)) as pool:
        rates = list(pool.map(_one_core_rate, [(problem, choice)] * CORES))
    yield (
        f"PPO training, {CORES} trials side by side, a core each", _per_second(sum(rates)),
        "40 k steps/s", f"{sum(rates) / 40e3:.2f}",
    )  # fmt: skip


def one_batch_of_trainings(parameters: dict) -> Iterator[Row]:
    """Processor seconds of `TOGETHER` trainings in one batch, and of one alone; where there is a
    GPU, seconds there.
    """
    problem = _problem(parameters, CENTRE)
    choice = Choice(tuple(first_guess(problem, SEARCH).values()))
    settings = replace(SETTINGS, updates=10, evaluate_every=10)
    torch.set_num_threads(1)
    one = Training(problem, choice, settings)
    many = [replace(one, settings=replace(settings, seed=seed)) for seed in range(TOGETHER)]
    steps = settings.updates * REACH.rollout_steps * ENVIRONMENTS
    alone = steps / _processor_seconds(lambda: learn_alone(one))
    together = (
        TOGETHER * steps / _processor_seconds(lambda: learn_side_by_side(many, device=MUJOCO))
    )
    yield (
        f"PPO, {TOGETHER} trainings in one batch, one core", _per_second(together),
        f"one alone, {_per_second(alone)}", f"{together / alone:.2f}",
    )  # fmt: skip
    if device_for(problem.task) == MUJOCO:
        return
    learn_side_by_side(many)
    began = time.perf_counter()
    learn_side_by_side(many)
    rate = TOGETHER * steps / (time.perf_counter() - began)
    yield (
        "… on the GPU",
        _per_second(rate),
        f"one alone, {_per_second(alone)}",
        f"{rate / alone:.0f}",
    )


def _processor_seconds(run: Callable[[], object]) -> float:
    began = time.process_time()
    run()
    return time.process_time() - began


def _share(ready) -> None:
    global _ready
    _ready = ready


def _one_core_rate(given: tuple[Problem, Choice]) -> float:
    problem, choice = given
    torch.set_num_threads(1)
    environments = problem.environments(choice, SETTINGS, ENVIRONMENTS, 42, True, 1)
    ppo = make_model(environments, 42)
    steps = REACH.rollout_steps * ENVIRONMENTS
    ppo.learn(2 * steps, log_interval=None)
    _ready.wait()
    return _rate(lambda: ppo.learn(20 * steps, log_interval=None), 20 * steps)


def time_to_succeed(parameters: dict) -> Iterator[Row]:
    """Until a policy succeeds in 95 % of its episodes and keeps every constraint."""
    for cell in CORNERS:
        environments, choice = _made(parameters, cell)
        judges = _problem(parameters, cell).environments(
            choice, SETTINGS, PROGRESS_EPISODES, 43, threads=CORES
        )
        seen: list[Evaluation] = []
        began = time.perf_counter()
        ALGORITHMS.find(LEARNING["algorithm"])().train(
            environments,
            judges,
            Settings(**{**LEARNING, "enough": 0.95}),
            lambda _, found, seen=seen: seen.append(found),
        )
        seconds = time.perf_counter() - began
        yield (
            f"Joint-Reach at {cell.name}, action scales of the first trial",
            f"{100 * seen[-1].success:.0f} % in {seconds:.0f} s", "95 % in 60 s",
            f"{seconds / 60:.2f}",
        )  # fmt: skip


def _problem(parameters: dict, cell: Cell) -> Problem:
    return Problem(
        CONDITION,
        cell,
        parameters[cell],
        CONFIGURATION["identification"]["rate_hz"],
        HORIZON_S,
    )


def _made(parameters: dict, cell: Cell):
    problem = _problem(parameters, cell)
    guess = first_guess(problem, SEARCH)
    choice = Choice(tuple(guess.values()))
    return problem.environments(choice, SETTINGS, ENVIRONMENTS, 42, True, CORES), choice


class _Maker:
    """Makes an environment in another process."""

    def __init__(self, problem: Problem, choice: Choice, seed: int):
        self.given = problem, choice, seed

    def __call__(self) -> GymnasiumReach:
        return GymnasiumReach(*self.given)


class _Stopwatch:
    """Seconds spent in a method."""

    seconds = 0.0

    def around(self, owner: type, name: str):
        """A patch that times `owner.name` while it lasts."""
        original = getattr(owner, name)

        def timed(*args, **kwargs):
            began = time.perf_counter()
            try:
                return original(*args, **kwargs)
            finally:
                self.seconds += time.perf_counter() - began

        return patch.object(owner, name, timed)


def _rate(work: Callable[[], None], steps: int) -> float:
    began = time.perf_counter()
    work()
    return steps / (time.perf_counter() - began)


def _per_second(rate: float) -> str:
    return f"{rate / 1e3:.0f} k steps/s" if rate >= 1e4 else f"{rate / 1e3:.1f} k steps/s"
