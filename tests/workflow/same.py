"""Whether two runs came to the same numbers."""

import os
from collections.abc import Collection
from pathlib import Path

import numpy as np
import pandas as pd
import yaml

# how long something took, which no two runs share
TIMED = {"seconds"}
READERS = {".parquet": pd.read_parquet, ".csv": pd.read_csv}


def comparable(path: str) -> bool:
    """Numbers: pictures carry dates, journals the names of processes."""
    return os.path.splitext(path)[1] in {*READERS, ".yaml", ".npz", ".md", ".tex"}


def assert_same(path: Path, other: Path, but: Collection[str] = TIMED) -> None:
    """Fail where an artefact differs from another in more than the columns or keys `but`."""
    if path.suffix in READERS:
        ours, theirs = (READERS[path.suffix](p) for p in (path, other))
        kept = [column for column in theirs if column not in but]
        pd.testing.assert_frame_equal(ours[kept], theirs[kept], obj=str(path))
    elif path.suffix == ".npz":
        with np.load(path) as ours, np.load(other) as theirs:
            assert ours.files == theirs.files, path
            for name in ours.files:
                np.testing.assert_array_equal(ours[name], theirs[name], err_msg=str(path))
    elif path.suffix == ".yaml":
        ours, theirs = (yaml.safe_load(p.read_text()) for p in (path, other))
        for key in but:
            ours.pop(key, None), theirs.pop(key, None)
        assert ours == theirs, path
    else:
        assert path.read_text() == other.read_text(), path
