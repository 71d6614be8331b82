"""Reading artefacts: what is truncated, foreign or of another shape is named."""

import errno
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from t2l import documents
from t2l.errors import ArtefactError, InputError, T2LError

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa

# a comparison of a thousand recordings has some megabytes
MOST_BYTES = 100_000_000

# these say nothing about the file
_NOT_ITS_FAULT = (
    errno.EMFILE, errno.ENFILE, errno.ENOMEM, errno.ENOSPC, errno.EDQUOT, errno.EROFS
)  # fmt: skip


@contextmanager
def reading(path: Path | str, what: str) -> Iterator[None]:
    """Tell what goes wrong while the content of a file is made sense of.

    Args:
        what: it should hold, in a few words.

    Raises:
        ArtefactError: the body could not make sense of it.
    """
    try:
        yield
    except ArtefactError:
        raise
    except (
        ArithmeticError, AttributeError, LookupError, T2LError, TypeError, ValueError
    ) as error:  # fmt: skip
        raise ArtefactError(path, f"makes no sense ({_reason(error)})", what) from None


def _reason(error: BaseException) -> str:
    text = " ".join(str(error).split())[:300]
    if isinstance(error, LookupError):
        return f"lacks {text}"
    return text or type(error).__name__


@contextmanager
def parsing(path: Path, expected: str) -> Iterator[None]:
    """Tell what goes wrong while a library parses a file: each has errors of its own.

    Raises:
        ArtefactError: it failed, and not because the system is out of memory or of files.
    """
    try:
        yield
    except ArtefactError:
        raise
    except Exception as error:
        if isinstance(error, OSError) and error.errno in _NOT_ITS_FAULT:
            raise
        raise ArtefactError(path, f"cannot be read ({_reason(error)})", expected) from None


def checked_file(path: Path | str, expected: str) -> Path:
    """A file that is there and not empty.

    Raises:
        ArtefactError: it is not.
    """
    path = Path(path)
    if not os.path.lexists(path):
        raise ArtefactError(path, "no such file", expected)
    if path.is_dir():
        raise ArtefactError(path, "a folder", expected)
    if not path.is_file():
        raise ArtefactError(path, "no regular file", expected)
    if path.stat().st_size == 0:
        raise ArtefactError(path, "an empty file", expected)
    return path


def read_text(path: Path | str, what: str) -> str:
    """The text of a file.

    Raises:
        ArtefactError: the file is missing, empty or not text.
    """
    path = checked_file(path, what)
    try:
        return documents.read_text(path, what, MOST_BYTES)
    except InputError as error:
        raise ArtefactError(path, f"found {error.found}", what) from None


def read_json(path: Path | str, what: str, keys: Sequence[str] = ()) -> dict[str, Any]:
    """The object that a JSON file holds.

    Args:
        what: the file is, in a few words.
        keys: it must have.

    Raises:
        ArtefactError: the file is missing, cut short, not JSON, no object, or lacks a key.
    """
    expected = _expected(f"{what}, a JSON object", "keys", keys)
    path = checked_file(path, expected)
    try:
        content = documents.read_json(path, expected, MOST_BYTES)
    except InputError as error:
        raise ArtefactError(path, f"found {error.found}", expected) from None
    return _with_keys(content, path, keys, expected)


def read_yaml(path: Path | str, what: str, keys: Sequence[str] = ()) -> dict[str, Any]:
    """The mapping that a YAML file holds; likewise.

    Raises:
        ArtefactError: the file is missing, cut short, not YAML, no mapping, or lacks a key.
    """
    expected = _expected(f"{what}, a YAML mapping", "keys", keys)
    path = checked_file(path, expected)
    try:
        content = documents.read_yaml(path, expected)
    except InputError as error:
        raise ArtefactError(path, f"found {error.found}", expected) from None
    return _with_keys(content, path, keys, expected)


def _expected(what: str, parts: str, names: Sequence[str]) -> str:
    return f"{what} with {parts} {', '.join(names)}" if names else what


def _with_keys(content: Any, path: Path, keys: Sequence[str], expected: str) -> dict[str, Any]:
    if not isinstance(content, dict):
        raise ArtefactError(path, f"a {type(content).__name__}", expected)
    missing = [key for key in keys if key not in content]
    if missing:
        raise ArtefactError(path, f"lacks {', '.join(missing)}", expected)
    return content


def read_npz(path: Path | str, names: Sequence[str] = ()) -> dict[str, np.ndarray]:
    """The arrays of an .npz file, those in `names` among them.

    Raises:
        ArtefactError: the file is missing, cut short, no .npz, or lacks an array.
    """
    expected = _expected("an .npz file", "arrays", names)
    path = checked_file(path, expected)
    with parsing(path, expected):
        content = np.load(path, allow_pickle=False)
        if not isinstance(content, np.lib.npyio.NpzFile):
            raise ArtefactError(path, "a single array", expected)
        with content:
            arrays = {name: content[name] for name in content.files}
        odd = [name for name, array in arrays.items() if not isinstance(array, np.ndarray)]
        if odd:
            raise ArtefactError(path, f"{odd[0]} is no array", expected)
    missing = [name for name in names if name not in arrays]
    if missing:
        raise ArtefactError(path, f"lacks {', '.join(missing)}", expected)
    return arrays


def read_arrow(path: Path | str, columns: Sequence[str], whole_table: bool = False) -> "pa.Table":
    """`columns` of a Parquet table, or all that it holds.

    Raises:
        ArtefactError: the file is missing, not Parquet, cut short, or lacks a column.
    """
    # not read_table, which would import pandas
    from pyarrow.parquet import ParquetFile

    expected = _expected("a Parquet table", "columns", columns)
    path = checked_file(path, expected)
    with parsing(path, expected), path.open("rb") as file:
        parquet = ParquetFile(file, page_checksum_verification=True)
        _check_columns(parquet.schema_arrow.names, path, columns, expected)
        wanted = None if whole_table else list(columns)
        table = parquet.read(columns=wanted, use_threads=False)
        table.validate(full=True)
    return table


def read_table(path: Path | str, columns: Sequence[str]) -> "pd.DataFrame":
    """Read a table, Parquet or CSV, that must have `columns`.

    Raises:
        ArtefactError: the file is missing, not a table, cut short, or lacks a column.
    """
    path = Path(path)
    if path.suffix == ".csv":
        return _read_csv(path, columns)
    expected = _expected("a Parquet table", "columns", columns)
    table = read_arrow(path, columns, whole_table=True)
    with parsing(path, expected):
        return table.to_pandas()


def _read_csv(path: Path, columns: Sequence[str]) -> "pd.DataFrame":
    # pandas takes a second to import, and not every job reads tables
    import pandas as pd

    expected = _expected("a CSV table", "columns", columns)
    path = checked_file(path, expected)
    with parsing(path, expected):
        table = pd.read_csv(path)
    _check_columns(list(table.columns), path, columns, expected)
    return table


def _check_columns(found: Sequence[str], path: Path, columns: Sequence[str], expected: str) -> None:
    missing = [column for column in columns if column not in found]
    if missing:
        raise ArtefactError(path, f"lacks column {', '.join(missing)}", expected)
