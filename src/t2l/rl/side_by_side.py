"""Many trainings of one condition at once, on a GPU where there is one.

Trainings may differ in their cell, action scales and seed. Which of them are together changes the
noise that each meets, and so its numbers, but not what they mean.
"""

import importlib.util
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from t2l.environment.interface import action_space, scale_per_joint
from t2l.policies import Policy
from t2l.rl.algorithm import Algorithm, Report, Trained, TrainingEnded, TrainingError
from t2l.rl.evaluate import evaluate_side_by_side
from t2l.rl.learn import EPISODES, PROGRESS_EPISODES, gain_of, judge, learn
from t2l.rl.problem import Choice, Problem
from t2l.rl.registry import ALGORITHMS
from t2l.rl.results import Evaluation
from t2l.rl.settings import Settings
from t2l.rl.unfinished import Unfinished
from t2l.sim.batch import MUJOCO
from t2l.tasks import Rewarded


@dataclass(frozen=True, eq=False)
class Training:
    """One of the trainings; see `t2l.rl.learn.learn`.

    Attributes:
        unfinished: where its state is kept; of trainings side by side, all have it or none.
    """

    problem: Problem
    choice: Choice
    settings: Settings
    report: Report = lambda update, policy, evaluation: None
    unfinished: Unfinished | None = None


def device_for(task: Rewarded) -> str:
    """Where a task's simulations run fastest, of what this machine has."""
    import torch

    here = torch.cuda.is_available() and importlib.util.find_spec("mujoco_warp") is not None
    return "cuda" if here and task.on_gpu else MUJOCO


def learn_side_by_side(
    trainings: Sequence[Training], threads: int = 1, device: str | None = None
) -> list[Trained | TrainingError | TrainingEnded]:
    """What `t2l.rl.learn.learn` gives or raises for each training.

    Args:
        trainings: of one condition, with the same settings but for the seed. One is trained alone.
        device: of the simulations; `device_for` the task unless given.
    """
    first = trainings[0]
    if not _together(trainings, device):
        return [learn_alone(training, threads) for training in trainings]
    where, algorithm = device or device_for(first.problem.task), _algorithm(first)
    kept = {}
    if first.unfinished and algorithm.resumes:
        kept["unfinished"] = Unfinished.together([training.unfinished for training in trainings])
    return algorithm().train_side_by_side(
        _world(trainings, first.settings.environments, 0, True, threads, where),
        _world(trainings, PROGRESS_EPISODES, 1, False, threads, where),
        [training.settings.seed for training in trainings],
        first.settings,
        [training.report for training in trainings],
        **kept,
    )


def judge_side_by_side(
    trainings: Sequence[Training],
    policies: Sequence[Policy],
    threads: int = 1,
    device: str | None = None,
    episodes: int = EPISODES,
) -> list[Evaluation]:
    """What `t2l.rl.learn.judge` says of the policy of each training."""
    first = trainings[0]
    if not _together(trainings, device):
        return [
            judge(t.problem, t.choice, t.settings, policy, threads, episodes)
            for t, policy in zip(trainings, policies, strict=True)
        ]
    where = device or device_for(first.problem.task)
    return evaluate_side_by_side(policies, _world(trainings, episodes, 2, False, threads, where))


def learn_and_judge(
    trainings: Sequence[Training], threads: int = 1
) -> list[tuple[Trained | TrainingError | TrainingEnded, Evaluation | None]]:
    """What each training gives or raises, and what is said of its policy; None if it left none."""
    if not trainings:
        return []
    trained = learn_side_by_side(trainings, threads)
    complete = [
        (training, one.policy)
        for training, one in zip(trainings, trained, strict=True)
        if isinstance(one, Trained)
    ]
    judged = iter(judge_side_by_side(*zip(*complete, strict=True), threads) if complete else ())
    return [(one, next(judged) if isinstance(one, Trained) else None) for one in trained]


def learn_alone(training: Training, threads: int = 1) -> Trained | TrainingError | TrainingEnded:
    """What `t2l.rl.learn.learn` gives or raises."""
    t = training
    try:
        return learn(t.problem, t.choice, t.settings, t.report, threads, t.unfinished)
    except (TrainingError, TrainingEnded) as reason:
        return reason


def _algorithm(training: Training) -> type[Algorithm]:
    return ALGORITHMS.find(training.settings.algorithm)


def _together(trainings: Sequence[Training], device: str | None) -> bool:
    """Whether one world can hold them: they differ in cell, action scales and seed alone."""
    first = trainings[0]
    able = _algorithm(first).side_by_side
    return (able and (len(trainings) > 1 or device is not None)) and all(
        training.problem.condition == first.problem.condition
        and training.choice.reward_weights == first.choice.reward_weights
        and replace(training.settings, seed=0) == replace(first.settings, seed=0)
        for training in trainings
    )


def _world(
    trainings: Sequence[Training], n: int, offset: int, training: bool, threads: int, device: str
):
    """As `Problem.environments` of each training, with the seed of its settings plus `offset`."""
    from t2l.environment.environment import Environment
    from t2l.rl.environments import randomised

    first = trainings[0]
    problem, robot = first.problem, first.problem.task.robot
    generators = [np.random.default_rng(t.settings.seed + offset) for t in trainings]
    parameters = [
        randomised(t.problem.parameters, n, problem.randomisation(training), generator)
        for t, generator in zip(trainings, generators, strict=True)
    ]
    scales = [scale_per_joint(t.choice.action_scale, robot) for t in trainings]
    gains = np.repeat([(t.problem.cell.kp, t.problem.cell.kd) for t in trainings], n, axis=0)
    return Environment(
        problem.task.reweighted(first.choice.reward_weights), gains[:, :1], gains[:, 1:],
        {name: np.concatenate([own[name] for own in parameters]) for name in parameters[0]},
        action_space(problem.condition.actions, robot, np.repeat(scales, n, axis=0)), generators, n,
        threads=threads, device=device, **problem.of_world(first.settings, training),
    )  # fmt: skip


def policies_of(
    trainings: Sequence[Training], threads: int = 1
) -> list[tuple[Trained, Evaluation, float]]:
    """A policy of each training, how it does, and its feedback gain in its simulator.

    Raises:
        TrainingError: a training left no policy that can act.
    """
    trained = learn_side_by_side(trainings, threads)
    for one in trained:
        if isinstance(one, Exception):
            raise one
    found = judge_side_by_side(trainings, [one.policy for one in trained], threads)
    gains = [
        gain_of(t.problem, t.choice, t.settings, one.policy, threads)
        for t, one in zip(trainings, trained, strict=True)
    ]
    return list(zip(trained, found, gains, strict=True))
