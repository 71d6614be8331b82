"""Optuna's studies on disk: opened, continued after a kill, shared, read as tables, and the best.

It loads without torch.
"""

import json
import os
import re
import socket
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import optuna
from optuna.trial import FrozenTrial, TrialState

from t2l.artefacts import parsing
from t2l.environment.limits import NAMES
from t2l.errors import ArtefactError, T2LError, writing
from t2l.rl.problem import Choice, scale_names
from t2l.rl.results import Evaluation
from t2l.rl.settings import JOURNAL
from t2l.robots import Robot

if TYPE_CHECKING:
    import pandas as pd

# A worker on another machine that has not reported for so long is taken for dead. Optuna has
# heartbeats of its own for databases only, and none for the journal or for `ask` and `tell`.
SILENCE_S = 900.0

# of a trial's attributes, what says nothing about it to a reader of the table
INTERNAL = ("worker", "seen")

FINISHED = (TrialState.COMPLETE, TrialState.PRUNED)


class StorageError(T2LError):
    """Optuna's storage does not answer or is none."""


def open_study(
    storage: str, journal: Path | str, name: str, directions: Sequence[str] = ("maximize",)
) -> optuna.Study:
    """The study `name`, new or as it was left.

    Args:
        storage: `journal`, or the URL of a database.
        journal: file of the journal.
        directions: of each of its objectives, `maximize` or `minimize`.

    Raises:
        StorageError: the storage cannot be used.
        ArtefactError: the file of the journal is none.
        OutputError: the journal cannot be written.
    """
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    if storage == JOURNAL:
        return _open_journal(Path(journal), name, directions)
    with _answering(storage):
        return optuna.create_study(
            storage=storage, study_name=name, directions=directions, load_if_exists=True
        )


def _open_journal(path: Path, name: str, directions: Sequence[str]) -> optuna.Study:
    from optuna.storages.journal import (
        JournalFileBackend,
        JournalFileSymlinkLock,
        JournalStorage,
    )

    expected = "a journal of Optuna's trials"
    # the lock that a killed process leaves is a link to it: a relative one would lead nowhere, and
    # Optuna wait for ever
    absolute = str(path.absolute())
    lock = JournalFileSymlinkLock(absolute)
    if path.exists() and not path.is_file():
        raise ArtefactError(path, "no regular file", expected)
    with writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        lock.acquire()
        try:
            _mend_journal(path, expected)
        finally:
            lock.release()
        with parsing(path, expected):
            return optuna.create_study(
                storage=JournalStorage(JournalFileBackend(absolute, lock_obj=lock)),
                study_name=name, directions=directions, load_if_exists=True,
            )  # fmt: skip


def _mend_journal(path: Path, expected: str) -> None:
    """Take an unfinished last line away, which Optuna would write on in; refuse any other.

    A kill while a line is written leaves a part of it: what it was to say has not happened.
    """
    if not path.exists():
        return
    *lines, last = path.read_bytes().split(b"\n")
    for number, line in enumerate(lines, start=1):
        if not _is_operation(line):
            raise ArtefactError(path, f"line {number} is no operation on a study", expected)
    if not last:
        return
    if not lines and not last.startswith(b'{"op_code":'):
        raise ArtefactError(path, "line 1 is no operation on a study", expected)
    with path.open("r+b") as file:
        if _is_operation(last):
            file.seek(0, os.SEEK_END)
            file.write(b"\n")
        else:
            file.truncate(path.stat().st_size - len(last))


def _is_operation(line: bytes) -> bool:
    try:
        content = json.loads(line)
    except (ValueError, RecursionError):
        return False
    return isinstance(content, dict) and "op_code" in content


@contextmanager
def _answering(storage: str) -> Iterator[None]:
    shown = re.sub(r"//[^@/]*@", "//…@", storage)
    allowed = f"allowed: {JOURNAL}, or the URL of a database that answers, such as sqlite:///F.db"
    try:
        yield
    # every database driver has errors of its own
    except Exception as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        reason = re.sub(r"//[^@/\s]*@", "//…@", reason)
        raise StorageError(
            f"Optuna's storage {shown}: cannot be used ({reason[:300]}); {allowed}"
        ) from None


def sign(trial: optuna.Trial) -> None:
    """Leave this process's name on a trial, and the time: repeated, it says `still at work`."""
    trial.set_user_attr("worker", f"{socket.gethostname()}:{os.getpid()}")
    trial.set_user_attr("seen", time.time())


def alive(trial: FrozenTrial) -> bool:
    """Whether the process that runs a trial still does, as far as can be seen from here."""
    seen = trial.user_attrs.get("seen")
    if seen is None:  # it was asked for, and not signed yet
        started = trial.datetime_start
        return started is not None and time.time() - started.timestamp() < SILENCE_S
    host, _, pid = trial.user_attrs["worker"].rpartition(":")
    if host == socket.gethostname():
        return Path(f"/proc/{pid}").exists()
    return time.time() - seen < SILENCE_S


def requeue_abandoned(study: optuna.Study) -> list[int]:
    """Fail trials that killed processes left running, and queue their parameters again."""
    requeued = []
    for trial in study.get_trials(deepcopy=False, states=(TrialState.RUNNING,)):
        if alive(trial):
            continue
        try:
            study.tell(trial.number, state=TrialState.FAIL)
        except ValueError:  # another worker was faster
            continue
        if trial.params:
            study.enqueue_trial(trial.params)
        requeued.append(trial.number)
    return requeued


def count(study: optuna.Study, *states: TrialState) -> int:
    """How many trials are in one of `states`."""
    return len(study.get_trials(deepcopy=False, states=states))


def table(study: optuna.Study) -> "pd.DataFrame":
    """One row a trial that finished: number, state, value, what it chose, what it came to."""
    import pandas as pd

    return pd.DataFrame(
        [
            {"number": trial.number, "state": trial.state.name.lower(), "objective": trial.value}
            | trial.params
            | {k: v for k, v in trial.user_attrs.items() if k not in INTERNAL}
            for trial in study.get_trials(deepcopy=False, states=FINISHED)
        ]
    )


def no_trials(robot: Robot) -> "pd.DataFrame":
    """The table of a study that searched nothing."""
    import pandas as pd

    numbers = ("number", "objective", "success", *scale_names(robot))
    return pd.DataFrame({name: pd.Series(dtype=float) for name in numbers} | {"state": []})


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
