"""Which trials of tuning are not worth finishing."""

import optuna
from optuna.pruners import BasePruner, MedianPruner, ThresholdPruner
from optuna.trial import FrozenTrial, TrialState

from t2l.rl.trials import count

# an objective that only a policy which breaks the limits can have; with `solved_at`, a success
HOPELESS = 0.1


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
