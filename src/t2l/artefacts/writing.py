"""Writing artefacts whole or not at all."""

import hashlib
import os
import re
import shutil
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from t2l.errors import OutputError, writing

if TYPE_CHECKING:
    import pandas as pd

# of a file's name, what file systems take
_NAME_BYTES = 255
_LONGEST_SUFFIX = 32


@contextmanager
def whole(path: Path | str) -> Iterator[Path]:
    """Give a temporary path beside `path`; what was written there takes its place at the end.

    A file or a folder may be written; a file takes the place of a file. When the body raises, or
    the process is killed, `path` is as it was.

    Raises:
        OutputError: the system does not let it be written, or a folder is there.
    """
    path = Path(path)
    with writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        before, after = _draft_name(path)
        # what a killed process left: one job at a time writes an artefact
        stale = re.compile(f"{re.escape(before)}[0-9a-f]{{8}}{re.escape(after)}")
        for name in filter(stale.fullmatch, os.listdir(path.parent)):
            remove(path.with_name(name))
        draft = path.with_name(f"{before}{uuid.uuid4().hex[:8]}{after}")
        try:
            yield draft
            _put(draft, path)
        finally:
            remove(draft)


def _draft_name(path: Path) -> tuple[str, str]:
    """What comes before and after the eight digits of a draft's name."""
    mark = ".draft-"
    # same suffix: libraries choose a format by it
    after = path.suffix if len(os.fsencode(path.suffix)) <= _LONGEST_SUFFIX else ""
    stem = path.name.removesuffix(after)
    room = _NAME_BYTES - len(os.fsencode(f".{mark}{after}")) - 8
    if len(os.fsencode(stem)) > room:
        digest = hashlib.sha256(os.fsencode(stem)).hexdigest()[:16]
        stem = os.fsencode(stem)[: room - 17].decode(errors="ignore") + f"-{digest}"
    return f".{stem}{mark}", after


def _put(draft: Path, path: Path) -> None:
    try:
        os.replace(draft, path)
    except OSError:
        if path.is_dir():
            raise OutputError(f"{path}: cannot be written: a folder is there") from None
        if draft.is_dir() and path.exists():
            raise OutputError(f"{path}: cannot be written: a file is there") from None
        raise


def remove(path: Path) -> None:
    """Remove a file or link, if it is there, or a folder with what is in it."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def set_aside(path: Path | str) -> Path:
    """Rename a file or folder to NAME.broken, or NAME.broken2 … if that is taken; the new path.

    Raises:
        OutputError: the system does not let it be renamed.
    """
    path, count = Path(path), 1
    aside = path.with_name(f"{path.name}.broken")
    while os.path.lexists(aside):
        count += 1
        aside = path.with_name(f"{path.name}.broken{count}")
    with writing(aside):
        path.rename(aside)
    return aside


def write_table(table: "pd.DataFrame", path: Path | str) -> None:
    """Write a Parquet table whole, with checksums."""
    with whole(path) as draft:
        table.to_parquet(draft, index=False, write_page_checksum=True)


def write_text(text: str, path: Path | str) -> None:
    """Write a text file whole, in UTF-8."""
    with whole(path) as draft:
        draft.write_text(text, encoding="utf-8")
