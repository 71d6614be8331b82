"""Reading and writing artefacts: whole or not at all, and foreign ones named."""

import os
import shutil
import uuid
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING
from zipfile import BadZipFile

import yaml

from t2l.errors import ArtefactError

if TYPE_CHECKING:
    import pandas as pd


@contextmanager
def whole(path: Path | str) -> Iterator[Path]:
    """Give a temporary path beside `path`; what was written there takes its place at the end.

    A file or a folder may be written. When the body raises, or the process is killed, `path` is
    as it was.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    # what a killed process left: one job at a time writes an artefact
    for stale in path.parent.glob(f".{path.stem}.draft-*{path.suffix}"):
        _remove(stale)
    # same suffix: libraries choose a format by it
    draft = path.with_name(f".{path.stem}.draft-{uuid.uuid4().hex[:8]}{path.suffix}")
    try:
        yield draft
        if path.is_dir():
            shutil.rmtree(path)
        os.replace(draft, path)
    finally:
        _remove(draft)


def _remove(path: Path) -> None:
    if path.is_dir():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def write_table(table: "pd.DataFrame", path: Path | str) -> None:
    """Write a Parquet table whole."""
    with whole(path) as draft:
        table.to_parquet(draft, index=False)


def write_text(text: str, path: Path | str) -> None:
    """Write a text file whole."""
    with whole(path) as draft:
        draft.write_text(text)


@contextmanager
def reading(path: Path | str, what: str, writer: str) -> Iterator[None]:
    """Tell what goes wrong while a file is read that `writer` should have written.

    Args:
        what: it should hold, in a few words.

    Raises:
        ArtefactError: the body could not make sense of the file.
    """
    try:
        yield
    except (OSError, KeyError, TypeError, ValueError, yaml.YAMLError, BadZipFile) as error:
        reason = " ".join(str(error).split())
        raise ArtefactError(path, f"no {what} ({reason})", f"a file that {writer} wrote") from None


def read_table(path: Path | str, columns: Sequence[str]) -> "pd.DataFrame":
    """Read a Parquet table that must have `columns`.

    Raises:
        ArtefactError: the file is missing, not Parquet, cut short, or lacks a column.
    """
    # pandas takes a second to import, and not every job reads tables
    import pandas as pd
    import pyarrow as pa

    expected = f"a Parquet table with columns {', '.join(columns)}"
    try:
        table = pd.read_parquet(path)
    except FileNotFoundError:
        raise ArtefactError(path, "no such file", expected) from None
    except (pa.ArrowInvalid, OSError) as error:
        reason = str(error).splitlines()[0]
        raise ArtefactError(path, f"cannot be read as Parquet ({reason})", expected) from None
    missing = [column for column in columns if column not in table.columns]
    if missing:
        raise ArtefactError(path, f"lacks column {', '.join(missing)}", expected)
    return table
