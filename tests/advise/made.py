"""LeRobot data sets of the two-joint arm, small and written by hand."""

import json

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from tests.conftest import ROOT

ARM = str(ROOT / "examples/two_joint_arm/two_joint_arm.xml")
JOINTS = ("shoulder", "elbow")


def motion(number: int, rate_hz: float = 100.0, seconds: float = 2.0) -> np.ndarray:
    """(rows, 2) rad: from rest to rest, each a little further than the one before."""
    t = np.arange(round(seconds * rate_hz)) / rate_hz / seconds
    smooth = t**3 * (10 - 15 * t + 6 * t**2)
    return smooth[:, None] * (1 + 0.05 * number) * np.array([0.6, -0.8]) + [0.1, 0.2]


def dataset(
    folder,
    count=6,
    rate_hz=100,
    joints=JOINTS,
    lead=(0.02, -0.01),
    motions=motion,
    actions="{}",
):
    """A data set whose commands lead where the arm is."""
    features = {
        "action": {"shape": [len(joints)], "names": [actions.format(j) for j in joints]},
        "observation.state": {"shape": [len(joints)], "names": list(joints)},
    }
    parts = [motions(i, rate_hz) for i in range(count)]
    rows = [len(part) for part in parts]
    (folder / "meta").mkdir(parents=True)
    info = {
        "codebase_version": "v3.0", "fps": rate_hz, "total_frames": sum(rows), "features": features
    }  # fmt: skip
    (folder / "meta/info.json").write_text(json.dumps(info))
    state = np.concatenate(parts)
    table = pa.table(
        {
            "action": (state + lead).tolist(),
            "observation.state": state.tolist(),
            "episode_index": np.repeat(np.arange(count), rows),
            "frame_index": np.concatenate([np.arange(n) for n in rows]),
        }
    )
    (folder / "data/chunk-000").mkdir(parents=True)
    pq.write_table(table, folder / "data/chunk-000/file-000.parquet")
    return folder
