"""What a study of trials came to: its best trial's policy. It loads without torch."""

import logging
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import optuna
from optuna.trial import FrozenTrial, TrialState

from t2l.artefacts import read_table, reading
from t2l.errors import ArtefactError, T2LError
from t2l.names import is_plain
from t2l.policies import Policy, checkpoint
from t2l.rl.choice import Choice
from t2l.rl.constraints import NAMES, Evaluation
from t2l.rl.trials import FINISHED, POLICY, TRAINING, count

if TYPE_CHECKING:
    import pandas as pd

log = logging.getLogger(__name__)

SCALES = ("action_scale_proximal", "action_scale_distal")


class TuningError(T2LError):
    """A study that cannot give a policy."""


class UnfinishedError(TuningError):
    """A study with fewer usable trials than are wanted."""


@dataclass(frozen=True, eq=False)
class Best:
    """The best trial of a study."""

    number: int
    choice: Choice
    evaluation: Evaluation
    policy: Policy
    history: "pd.DataFrame"


def best(study: optuna.Study, store: Path | str, trials: int) -> Best:
    """The best of a study's trials whose files can be read; a warning tells of the others.

    Raises:
        UnfinishedError: fewer than `trials` have finished, or are worth nothing without files.
        TuningError: none of them gave a policy.
    """
    readable, broken = sort_by_files(study, store)
    done = count(study, *FINISHED)
    if done - len(broken) < trials:
        lost = f", the files of {len(broken)} of them unusable: {broken[0][1]}" if broken else ""
        raise UnfinishedError(
            f"study {study.study_name}: found {done} trials that finished{lost}; allowed: {trials}"
        )
    if not readable:
        raise TuningError(
            f"study {study.study_name}: found {done} trials that finished, 0 of them with a "
            f"policy; allowed: {trials}, at least one with a policy"
        )
    return max(readable, key=lambda entry: entry[0].value)[1]


def sort_by_files(
    study: optuna.Study, store: Path | str
) -> tuple[list[tuple[FrozenTrial, Best]], list[tuple[FrozenTrial, str]]]:
    """Trials that gave a policy: those whose files can be read, and the others with the reason."""
    readable, broken = [], []
    for trial in study.get_trials(deepcopy=False, states=(TrialState.COMPLETE,)):
        try:
            readable.append((trial, _of_trial(trial, Path(store))))
        except ArtefactError as error:
            log.warning("trial %d cannot be used: %s", trial.number, error.complaint)
            broken.append((trial, error.complaint))
    return readable, broken


def _of_trial(trial: FrozenTrial, store: Path) -> Best:
    attributes = trial.user_attrs
    with reading(store, f"what trial {trial.number} came to"):
        policy = checkpoint.load(store / _plain(attributes[POLICY]))
        history = read_table(store / _plain(attributes[TRAINING]), ("update", "steps", "reward"))
        weights = {name: value for name, value in trial.params.items() if name not in SCALES}
        scales = tuple(float(trial.params[name]) for name in SCALES)
        rates = {name: float(attributes[name]) for name in NAMES}
        evaluation = Evaluation(float(attributes["success"]), rates)
    return Best(trial.number, Choice(scales, weights), evaluation, policy, history)


def _plain(name: str) -> str:
    if not is_plain(name):
        raise ValueError(f"found {name!r} as the name of a file")
    return name
