"""How training goes: policies evaluated on the way, and the best of them.

The best is that of the highest reward, as in the study's appendix on reinforcement learning, or the
one that is enough. By the objective it would often be an early one, which keeps every limit because
it hardly moves.
"""

import logging
import math
import time
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from t2l.policies import POLICIES, Policy
from t2l.rl.algorithm import Report, Trained
from t2l.rl.results import Evaluation
from t2l.rl.settings import Settings
from t2l.sim.arrays import to_numpy

log = logging.getLogger(__name__)


class Progress:
    """Takes in how the policies of one training do.

    Attributes:
        enough: whether training may end: the last was good enough, or there is no time for more.
    """

    def __init__(self, settings: Settings, report: Report):
        """Begin; see `Algorithm.train`."""
        self.enough = False
        self._settings, self._report = settings, report
        self._began = time.perf_counter()
        self._history: list[dict[str, float]] = []
        self._best: tuple[Policy, Evaluation] | None = None
        self._highest = -math.inf

    def take(
        self,
        policy: Policy,
        found: Evaluation,
        update: int,
        steps: int,
        reward: float,
        terms: Mapping[str, float] | None = None,
        **more: float,
    ) -> None:
        """Report a policy, and keep it if it is the best so far.

        Args:
            found: how it does.
            update: after which it is so.
            steps: of all environments until then.
            reward: a second, since the evaluation before.
            terms: of which it is the sum, by name; told as the training goes.
            more: columns of the history.
        """
        terms = terms or {}
        log.info(
            "update %d: success %.2f, ended early %.2f; reward %.4g%s",
            *(update, found.success, found.failed, reward),
            " = " + " + ".join(f"{name} {value:.3g}" for name, value in terms.items())
            if terms
            else "",
        )
        self._history.append(
            {
                "update": update,
                "steps": steps,
                "seconds": time.perf_counter() - self._began,
                "reward": reward,
                "success": found.success,
                "failed": found.failed,
                **found.rates,
                "objective": found.objective,
                **more,
                **{f"reward_{name}": value for name, value in terms.items()},
            }
        )
        enough = self._settings.enough
        good = enough is not None and found.objective >= 1 + enough
        self.enough = good or self._late()
        reward = -math.inf if math.isnan(reward) else reward
        # what is good enough to end with is what it ends with
        if self._best is None or good or reward > self._highest:
            self._best, self._highest = (policy, found), reward
        self._report(update, policy, found)

    def _late(self) -> bool:
        """Whether one more evaluation, at the mean pace so far, would come after the limit."""
        limit, evaluations = self._settings.limit_s, len(self._history)
        if limit is None or self._history[-1]["seconds"] * (1 + 1 / evaluations) <= limit:
            return False
        log.info("ends: one more evaluation would come after %g s", limit)
        return True

    def state(self) -> dict[str, Any]:
        """What was taken in, as numbers, text and arrays, for `restore`."""
        policy, evaluation = self._best
        return {
            "seconds": time.perf_counter() - self._began,
            "history": self._history,
            "highest": self._highest,
            "enough": self.enough,
            "policy": policy.name,
            "metadata": policy.metadata(),
            "tensors": policy.tensors(),
            "evaluation": asdict(evaluation),
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        """Go on from a `state`, whose arrays may be tensors."""
        self._began = time.perf_counter() - state["seconds"]
        self._history = list(state["history"])
        self._highest, self.enough = state["highest"], state["enough"]
        tensors = {name: to_numpy(tensor) for name, tensor in state["tensors"].items()}
        policy = POLICIES.find(state["policy"]).restored(tensors, state["metadata"])
        self._best = policy, Evaluation(**state["evaluation"])

    def trained(self) -> Trained:
        """The best of the policies; at least one has been judged."""
        import pandas as pd

        policy, evaluation = self._best
        return Trained(policy, evaluation, pd.DataFrame(self._history))
