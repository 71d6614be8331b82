"""What a study of trials came to: the choice of its best one. It loads without torch."""

from dataclasses import dataclass

import optuna
from optuna.trial import FrozenTrial, TrialState

from t2l.environment.limits import NAMES
from t2l.errors import T2LError
from t2l.rl.choice import Choice, scale_names
from t2l.rl.constraints import Evaluation
from t2l.rl.trials import FINISHED, count
from t2l.robots import Robot


class TuningError(T2LError):
    """A study that cannot give a policy."""


class UnfinishedError(TuningError):
    """A study with fewer trials than are wanted."""


@dataclass(frozen=True)
class Best:
    """The best trial of a study."""

    number: int
    choice: Choice
    evaluation: Evaluation


def best(study: optuna.Study, robot: Robot, trials: int) -> Best:
    """The best of a study's complete trials.

    Raises:
        UnfinishedError: fewer than `trials` have finished.
        TuningError: none of them was completed.
    """
    done = count(study, *FINISHED)
    if done < trials:
        raise UnfinishedError(
            f"study {study.study_name}: found {done} trials that finished; allowed: {trials}"
        )
    complete = study.get_trials(deepcopy=False, states=(TrialState.COMPLETE,))
    if not complete:
        raise TuningError(
            f"study {study.study_name}: found {done} trials that finished, 0 of them with a "
            f"policy; allowed: {trials}, at least one with a policy"
        )
    return _of_trial(max(complete, key=lambda trial: trial.value), robot)


def _of_trial(trial: FrozenTrial, robot: Robot) -> Best:
    known = trial.params | trial.user_attrs
    weights = {name: v for name, v in trial.params.items() if not name.startswith("action_scale_")}
    choice = Choice(tuple(float(known[name]) for name in scale_names(robot)), weights)
    evaluation = Evaluation(float(known["success"]), {name: float(known[name]) for name in NAMES})
    return Best(trial.number, choice, evaluation)
