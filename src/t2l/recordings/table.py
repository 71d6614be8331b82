"""A recording's table as an array of numbers: CSV or Parquet, with faults found by row."""

import csv
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv as pa_csv
import pyarrow.parquet as pa_parquet

from t2l.documents import check_size
from t2l.errors import RecordingError
from t2l.typed import describe

ALLOWED_CELL = "a number, or nothing where not sampled"
NOT_SAMPLED = ("", "nan", "NaN")
# a column without any value has the type null
NUMERIC = (pa.types.is_floating, pa.types.is_integer, pa.types.is_null)


def read_numbers(
    path: Path, check_columns: Callable[[Sequence[str]], None]
) -> tuple[list[str], np.ndarray]:
    """The column names of a table, and its cells, (rows, columns), NaN where empty.

    Args:
        path: a .csv or .parquet.
        check_columns: raises if the column names are wrong, before any cell is looked at.

    Raises:
        RecordingError: the table cannot be read, or a cell is not a number.
    """
    read = _read_csv if path.suffix == ".csv" else _read_parquet
    columns, table = read(path, check_columns)
    # through a tensor: a column's own to_numpy would import pandas, which takes a second
    batches = table.combine_chunks().to_batches()
    if not batches or not columns:
        return columns, np.empty((0, len(columns)))
    return columns, batches[0].to_tensor(null_to_nan=True).to_numpy()


def _read_csv(path: Path, check_columns: Callable) -> tuple[list[str], pa.Table]:
    header = _header(path)
    check_columns(header)
    try:
        table = pa_csv.read_csv(
            path,
            # one thread: a recording is small, and many are read
            read_options=pa_csv.ReadOptions(use_threads=False, column_names=header, skip_rows=1),
            convert_options=pa_csv.ConvertOptions(
                column_types={name: pa.float64() for name in header}, null_values=NOT_SAMPLED
            ),
        )
    except (pa.ArrowException, OSError) as error:
        _find_fault(path)
        reason = str(error).splitlines()[0]
        raise RecordingError(path, "the file", reason, "rows of numbers below a header") from None
    return header, table


def _header(path: Path) -> list[str]:
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            return [name.strip() for name in next(csv.reader(file), [])]
    except (UnicodeDecodeError, csv.Error, OSError) as error:
        raise _not_text(path, error) from None


def _not_text(path: Path, error: Exception) -> RecordingError:
    return RecordingError(path, "the file", f"what is not text ({error})", "CSV in UTF-8")


def _find_fault(path: Path) -> None:
    """Raise for the first row of a CSV that has another length or a cell that is no number."""
    try:
        _check_rows(path)
    except (UnicodeDecodeError, csv.Error) as error:
        raise _not_text(path, error) from None


def _check_rows(path: Path) -> None:
    with path.open(newline="", encoding="utf-8-sig") as file:
        rows = csv.reader(file)
        header = next(rows, [])
        for number, row in enumerate((row for row in rows if row), start=1):
            if len(row) != len(header):
                raise RecordingError(
                    path, f"row {number}", f"{len(row)} cells", f"{len(header)}, as in the header"
                )
            for column, cell in zip(header, row, strict=True):
                try:
                    float(cell.strip() or "nan")
                except ValueError:
                    raise RecordingError(
                        path, f"row {number}, column {column}", describe(cell), ALLOWED_CELL
                    ) from None


def _read_parquet(path: Path, check_columns: Callable) -> tuple[list[str], pa.Table]:
    try:
        # a file object: a path would also let folder names become columns
        with path.open("rb") as file:
            parquet = pa_parquet.ParquetFile(file)
            check_size(parquet, path, RecordingError)
            table = parquet.read(use_threads=False)
    except (pa.ArrowException, OSError, ValueError) as error:
        reason = (str(error).splitlines() or [type(error).__name__])[0]
        raise RecordingError(
            path, "the file", f"what cannot be read ({reason})", "a Parquet table"
        ) from None
    check_columns(table.column_names)
    for field in table.schema:
        switch = field.name.startswith("torque_enabled") and pa.types.is_boolean(field.type)
        if not switch and not any(fits(field.type) for fits in NUMERIC):
            raise RecordingError(path, f"column {field.name}", f"{field.type} cells", ALLOWED_CELL)
    numbers = pa.schema([(name, pa.float64()) for name in table.column_names])
    return table.column_names, table.cast(numbers, safe=False)
