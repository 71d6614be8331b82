"""What cameras see of demonstrations: rendered once, and shared by all cells.

Retargeted replays go through the states of their demonstrations, so these pictures are theirs too.
On Block Stack at 50 Hz no joint was off by 4 mrad, nor a held block by 3 mm, at the corners of the
grid. They are a LeRobot data set with an episode a demonstration, in PNG, which loses nothing.
"""

import io
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa

from t2l.artefacts import parsing, read_arrow
from t2l.demos.dataset import IMAGES, by_camera, image_features, read_features, write_set
from t2l.demos.demonstration import Demonstration
from t2l.demos.episodes import NUMBER
from t2l.demos.retarget import replayed
from t2l.errors import ArtefactError, CameraError
from t2l.tasks import Task
from t2l.tasks.cameras import Cameras

# of 255: a picture with less in it is of one colour, shaded
CONTRAST = 16


def render(
    demonstrations: Iterable[Demonstration], cameras: Cameras, decimation: int, how: str
) -> Iterator[np.ndarray]:
    """Of each demonstration the pictures (n, ncamera, height, width, 3) before each held command.

    Args:
        decimation, how: of the commands, see `t2l.demos.retarget.hold`.

    Raises:
        CameraError: a camera sees one colour all along, or nothing that moves.
    """
    for number, demonstration in enumerate(demonstrations):
        pictures = cameras.pictures(replayed(demonstration, decimation, how))
        for name, seen in zip(cameras.names, np.moveaxis(pictures, 1, 0), strict=True):
            if np.ptp(seen, axis=(1, 2)).max() < CONTRAST:
                problem = "pictures of one colour"
            elif len(seen) > 1 and (seen == seen[0]).all():
                problem = "the same picture all along"
            else:
                continue
            raise CameraError(
                f"camera {name}: found {problem} in demonstration {number}; allowed: a camera that "
                "sees what happens. Leave it out of observation.cameras, or move it in the task."
            )
        yield pictures


def write_pictures(
    episodes: Iterable[np.ndarray], cameras: Cameras, task: Task, fps: int, path: Path
) -> None:
    """Write what `render` gives."""
    frames = (by_camera(cameras.names, pictures) for pictures in episodes)
    write_set(path, task, fps, image_features(cameras.names, cameras.size_px), frames)


def read_pictures(
    path: Path | str, cameras: Sequence[str], size_px: int
) -> tuple[np.ndarray, list[np.ndarray]]:
    """What `write_pictures` wrote: a store of all pictures, and each demonstration's indices in it.

    Returns:
        (N, ncamera, height, width, 3) uint8, and (n,) of each demonstration.

    Raises:
        ArtefactError: the folder is missing, cut short, or lacks a camera's pictures of this size.
    """
    path, keys = Path(path), [IMAGES + name for name in cameras]
    files, total = read_features(path, {key: [size_px, size_px, 3] for key in keys})
    store = np.empty((total, len(keys), size_px, size_px, 3), np.uint8)
    numbers, end = [], 0
    for file in files:
        table = read_arrow(file, [NUMBER, *keys])
        numbers.append(table[NUMBER].to_numpy())
        begin, end = end, end + len(table)
        if end > total:
            break
        for i, key in enumerate(keys):
            _decode(file, table[key], store[begin:end, i])
    if end != total:
        raise ArtefactError(path, f"other frames than the {total} of info.json", "pictures")
    of = np.concatenate(numbers)
    return store, [np.flatnonzero(of == number) for number in range(of.max() + 1)]


def _decode(file: Path, column: pa.ChunkedArray, pictures: np.ndarray) -> None:
    from PIL import Image

    expected = f"PNG of {' by '.join(map(str, pictures.shape[1:3]))} pixels"
    with parsing(file, expected):
        for scalar, picture in zip(column, pictures, strict=True):
            picture[:] = np.asarray(Image.open(io.BytesIO(scalar["bytes"].as_py())))
