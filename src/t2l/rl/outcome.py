"""What a study of trials came to: its best trial's policy. It loads without torch."""

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import optuna
from optuna.artifacts import FileSystemArtifactStore, download_artifact
from optuna.trial import TrialState

from t2l.errors import T2LError
from t2l.rl import policy as policies
from t2l.rl.choice import Choice
from t2l.rl.constraints import NAMES, Evaluation
from t2l.rl.policy import ReachPolicy
from t2l.rl.trials import FINISHED, POLICY, TRAINING, count

if TYPE_CHECKING:
    import pandas as pd

SCALES = ("action_scale_proximal", "action_scale_distal")


class TuningError(T2LError):
    """A study that cannot give a policy."""


@dataclass(frozen=True, eq=False)
class Best:
    """The best trial of a study."""

    number: int
    choice: Choice
    evaluation: Evaluation
    policy: ReachPolicy
    history: "pd.DataFrame"


def best(study: optuna.Study, store: Path | str, trials: int) -> Best:
    """The best of a study's trials.

    Raises:
        TuningError: fewer than `trials` have finished, or none of them gave a policy.
    """
    import pandas as pd

    done, complete = count(study, *FINISHED), count(study, TrialState.COMPLETE)
    if done < trials or not complete:
        raise TuningError(
            f"study {study.study_name}: found {done} trials that finished, {complete} of them "
            f"with a policy; allowed: {trials}, at least one with a policy"
        )
    frozen = study.best_trial
    attributes = frozen.user_attrs
    with tempfile.TemporaryDirectory() as folder:
        paths = {}
        for name in (POLICY, TRAINING):
            paths[name] = Path(folder, name)
            _fetch(store, attributes[name], paths[name])
        policy = policies.load(paths[POLICY])
        history = pd.read_parquet(paths[TRAINING])
    weights = {name: value for name, value in frozen.params.items() if name not in SCALES}
    scales = tuple(frozen.params[name] for name in SCALES)
    rates = {name: attributes[name] for name in NAMES}
    return Best(
        frozen.number, Choice(scales, weights), Evaluation(attributes["success"], rates),
        policy, history,
    )  # fmt: skip


def _fetch(store: Path | str, key: str, path: Path) -> None:
    try:
        download_artifact(
            artifact_store=FileSystemArtifactStore(base_path=str(store)),
            file_path=str(path), artifact_id=key,
        )  # fmt: skip
    except optuna.artifacts.exceptions.ArtifactNotFound:
        raise TuningError(
            f"{store}: lacks the file {key} that a trial left; allowed: the folder that the "
            "study's workers wrote to"
        ) from None
