"""Writing what was imported, without ever touching what it was imported from."""

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from t2l.errors import RecordingError
from t2l.measurements.log import write_recording
from t2l.measurements.recording import Recording


def write_all(
    recordings: Sequence[Recording], folder: Path, format: Literal["csv", "parquet"] = "csv"
) -> list[Path]:
    """Write recordings into a folder by their names.

    Returns:
        The paths of the tables.

    Raises:
        RecordingError: two have one name, or a table would replace the file it comes from.
    """
    names = [recording.name for recording in recordings]
    for recording in recordings:
        path = folder / f"{recording.name}.{format}"
        if names.count(recording.name) > 1:
            raise RecordingError(path, "the name", "it twice", "tables with different names")
        if recording.path is not None and path.resolve() == recording.path.resolve():
            raise RecordingError(
                path, "the folder", "the file to import", "another folder for the recordings"
            )
    return [write_recording(recording, folder / recording.name, format) for recording in recordings]
