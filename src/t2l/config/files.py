"""Files that a configuration names: whether they are there."""

import os
from collections.abc import Sequence
from pathlib import Path

from t2l.config.models.attenuation import Attenuation
from t2l.config.models.diagnosis import Diagnosis
from t2l.config.models.task_learning import Learning
from t2l.errors import InputError
from t2l.recordings import log
from t2l.registry import AGREED, WOULD_RUN, python_files, untrusted
from t2l.study.published.grids import ADDRESS, read_grids
from t2l.typed import Problem, describe

RECORDING = "a recording, or a folder with at least one"
PYTHON = "a Python file, or a folder with at least one"


def extended(extensions: Sequence[str] | None) -> list[Problem]:
    """What is to be loaded and is not there, or that nobody has agreed to run."""
    paths = extensions or []
    missing = [
        Problem(f"extensions[{i}]", f"{describe(path)}, which is not there", PYTHON)
        for i, path in enumerate(paths)
        if not _has_python(path)
    ]
    return missing or _would_run("extensions", paths)


def published(section: Attenuation) -> list[Problem]:
    """What is to be read beside the study's own cells and is not what it should be."""
    path, key = section.published_grids, "attenuation.published_grids"
    if path is None:
        return []
    if not (_fits_the_system(path) and os.path.isfile(path)):
        return [Problem(key, f"{describe(path)}, which is not there", f"a download of {ADDRESS}")]
    try:
        read_grids(path)
    except InputError as error:
        return [Problem(key, f"{error.path}, with {error.found} at {error.where}", error.allowed)]
    return []


def diagnosed(section: Diagnosis) -> list[Problem]:
    """What a diagnosis is to read and is not there, or to run and nobody has agreed to."""
    wanted = [
        (f"diagnosis.{key}[{i}]", path, allowed, exists)
        for key, allowed, exists in (
            ("recordings", RECORDING, _has_recording),
            ("holdout", RECORDING, _has_recording),
            ("effects", PYTHON, _has_python),
        )
        for i, path in enumerate(getattr(section, key) or [])
    ]
    if section.model:
        wanted.append(("diagnosis.model", section.model, "a model file", os.path.isfile))
    absent = [
        Problem(key, f"{describe(path)}, which is not there", allowed)
        for key, path, allowed, exists in wanted
        if not exists(path)
    ]
    return absent or [
        *_both(section),
        *_would_run("diagnosis.effects", section.effects or []),
    ]


def twins(section: Learning | None) -> list[Problem]:
    """What searches of gains are to make twins of, and is not there."""
    found = []
    for i, entry in enumerate(section.gain_searches if section else []):
        key, logs = f"learning.gain_searches[{i}]", entry.recordings or []
        if (entry.model is None) != (entry.recordings is None):
            given = "model" if entry.model else "recordings"
            found.append(Problem(key, f"{given} alone", "recordings and model together"))
        found += [
            Problem(f"{key}.recordings[{j}]", f"{describe(log)}, which is not there", RECORDING)
            for j, log in enumerate(logs)
            if not _has_recording(log)
        ]
        if entry.model and not os.path.isfile(entry.model):
            absent = f"{describe(entry.model)}, which is not there"
            found.append(Problem(f"{key}.model", absent, "a model file"))
    return found


def _both(section: Diagnosis) -> list[Problem]:
    """Recordings that are to be fitted and to be held out."""
    fitted = {
        file.resolve(): f"diagnosis.recordings[{i}]"
        for i, path in enumerate(section.recordings)
        for file in log.files(path)
    }
    return [
        Problem(
            f"diagnosis.holdout[{i}]",
            f"{describe(str(both[0]))}, which is in {fitted[both[0].resolve()]} too",
            "recordings that are not fitted",
        )
        for i, path in enumerate(section.holdout or [])
        if (both := [file for file in log.files(path) if file.resolve() in fitted])
    ]


def _would_run(key: str, paths: Sequence[str]) -> list[Problem]:
    return [Problem(key, f"{file}, {WOULD_RUN}", AGREED) for file in untrusted(python_files(paths))]


def _has_recording(path: str) -> bool:
    return _fits_the_system(path) and bool(log.files(path))


def _has_python(path: str) -> bool:
    return _fits_the_system(path) and any(file.is_file() for file in python_files([path]))


def _fits_the_system(path: str) -> bool:
    """Whether a path could be one: pathlib fails where a part is too long."""
    return all(len(os.fsencode(part)) <= 200 for part in Path(path).parts)
