"""How training goes: policies evaluated on the way, and the best of them."""

import time
from typing import TYPE_CHECKING

from t2l.policies import Policy
from t2l.rl.algorithm import Report, Trained
from t2l.rl.constraints import Evaluation
from t2l.rl.evaluate import evaluate
from t2l.rl.settings import Settings

if TYPE_CHECKING:
    from t2l.rl.environments import Environments


class Progress:
    """Evaluates the policies of one training.

    Attributes:
        enough: whether the last was so good that training may end.
    """

    def __init__(self, judges: "Environments", settings: Settings, report: Report):
        """Begin; see `Algorithm.train`."""
        self.enough = False
        self._judges, self._settings, self._report = judges, settings, report
        self._began = time.perf_counter()
        self._history: list[dict[str, float]] = []
        self._best: tuple[Policy, Evaluation] | None = None

    def judge(
        self, policy: Policy, update: int, steps: int, reward: float, **more: float
    ) -> Evaluation:
        """Evaluate a policy, report it, and keep it if it is the best so far.

        Args:
            update: after which it is so.
            steps: of all environments until then.
            reward: a step, since the evaluation before.
            more: columns of the history.
        """
        found = evaluate(policy, self._judges)
        self._history.append(
            {
                "update": update,
                "steps": steps,
                "seconds": time.perf_counter() - self._began,
                "reward": reward,
                "success": found.success,
                **found.rates,
                "objective": found.objective,
                **more,
            }
        )
        if self._best is None or found.objective > self._best[1].objective:
            self._best = policy, found
        enough = self._settings.enough
        self.enough = enough is not None and found.objective >= 1 + enough
        self._report(update, policy, found)
        return found

    def trained(self) -> Trained:
        """The best of the policies; at least one has been judged."""
        import pandas as pd

        policy, evaluation = self._best
        return Trained(policy, evaluation, pd.DataFrame(self._history))
