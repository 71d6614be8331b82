"""From what was chosen to a policy, and how it does."""

from t2l.policies import Policy
from t2l.rl.algorithm import Report, Trained
from t2l.rl.evaluate import evaluate
from t2l.rl.feedback import feedback_gain
from t2l.rl.problem import Choice, Problem
from t2l.rl.registry import ALGORITHMS
from t2l.rl.results import Evaluation
from t2l.rl.settings import Settings
from t2l.rl.unfinished import Unfinished

EPISODES = 100  # that judge a policy, the study's number
PROGRESS_EPISODES = 50  # that judge a policy while it trains


def learn(
    problem: Problem,
    choice: Choice,
    settings: Settings,
    report: Report = lambda update, policy, evaluation: None,
    threads: int = 1,
    unfinished: Unfinished | None = None,
) -> Trained:
    """Train a policy, see `Algorithm.train`.

    Args:
        unfinished: where the state of an algorithm that `resumes` is kept.
    """
    seed, algorithm = settings.seed, ALGORITHMS.find(settings.algorithm)()
    kept = {"unfinished": unfinished} if unfinished and algorithm.resumes else {}
    return algorithm.train(
        problem.environments(choice, settings, settings.environments, seed, True, threads),
        problem.environments(choice, settings, PROGRESS_EPISODES, seed + 1, threads=threads),
        settings,
        report,
        threads,
        **kept,
    )


def judge(
    problem: Problem,
    choice: Choice,
    settings: Settings,
    policy: Policy,
    threads: int = 1,
    episodes: int = EPISODES,
) -> Evaluation:
    """How a policy does over episodes on the processor that neither trained nor chose it."""
    judges = problem.environments(choice, settings, episodes, settings.seed + 2, threads=threads)
    return evaluate(policy, judges)


def gain_of(
    problem: Problem, choice: Choice, settings: Settings, policy: Policy, threads: int = 1
) -> float:
    """The feedback gain of a policy, in episodes of its own."""
    n, seed = PROGRESS_EPISODES, settings.seed + 3
    return feedback_gain(policy, problem.environments(choice, settings, n, seed, threads=threads))
