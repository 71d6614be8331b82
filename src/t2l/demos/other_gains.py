"""A LeRobot data set of one's own, as if it had been recorded under other gains.

Where the gains of a recording are known, its commands and measurements say what torque the
controller supplied, and TPR (see `t2l.demos.retarget`) gives the commands with which a controller
of other gains would have supplied the same at the same place:

    τ = Kp (q_des − q) − Kd q̇,   q_des' = q + Kp'⁻¹ (τ + Kd' q̇)

Both controllers cancel gravity alike, so that it drops out.
"""

import json
import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import ArrayLike

from t2l.artefacts import parsing
from t2l.documents import check_regular, read_json
from t2l.errors import RecordingError
from t2l.recordings.checks import COMMANDED, MOST_LEAD_RAD, MOST_RAD, RANGE_TOLERANCE_RAD
from t2l.recordings.importers.lerobot_dataset import ACTION, find, read_episodes, read_info
from t2l.sim.controllers.joint_pd import pd_torque, position_command

# 25 timesteps of the study's recordings, the longest hold at which its retargeting is faithful
SLOWEST_HZ = 20
# of the frames: where commands jump, a motor gives less than the law asks for
SATURATED = 0.01
STATS = "statistics of a LeRobot data set, by feature"
# those of a camera's pictures and of many joints are some kB
MOST_BYTES = 100_000_000
ENTRIES = ("data/", "images/", "videos/", "meta/")
_EPISODE, _FRAME = "episode_index", "frame_index"


@dataclass(frozen=True)
class Gains:
    """Of a joint position controller, N·m/rad and N·m·s/rad, one number or one for each joint."""

    kp: ArrayLike
    kd: ArrayLike


def commands(q_des: np.ndarray, q: np.ndarray, dq: np.ndarray, own: Gains, other: Gains):
    """What a controller of other gains would have been commanded, rad, shaped as `q`.

    Args:
        q_des, q: (n, njoint) rad.
        dq: (n, njoint) rad/s.
    """
    torque = pd_torque(q_des, q, dq, own.kp, own.kd)
    return position_command(q, dq, torque, other.kp, other.kd)


@dataclass(frozen=True)
class Retargeted:
    """The joints' new commands, (n, njoint) in the data set's unit, by episode.

    Attributes:
        places: of the joints in `action`.
        lead_rad: how far commands lie from where the robot is at most, before and after.
    """

    episodes: dict[int, np.ndarray]
    places: list[int]
    lead_rad: tuple[float, float]


def retarget_dataset(
    folder: Path,
    joints: Sequence[str],
    own: Gains,
    other: Gains,
    torque_limit: np.ndarray,
    ranges: np.ndarray,
    degrees: bool = False,
    action_indices: Sequence[int] | None = None,
    state_indices: Sequence[int] | None = None,
) -> Retargeted:
    """Retarget every episode; nothing is written.

    Args:
        own: gains that it was recorded under.
        torque_limit: (njoint,) N·m, infinite where unknown.
        ranges: (njoint, 2) rad, of the joints, infinite where unknown.
        degrees: positions and velocities of the data set are in degrees.
        action_indices, state_indices: where the joints are; by default found by name.

    Raises:
        RecordingError: the data set cannot be read, or torques cannot be reconstructed from it.
    """
    info = read_info(folder)
    _check_copied(folder)
    if info.fps < SLOWEST_HZ:
        raise RecordingError(
            folder / "meta" / "info.json", "key fps", f"{info.fps:g}",
            f"{SLOWEST_HZ} or more: a torque changes too much while a command is held for longer",
        )  # fmt: skip
    where = find(folder, info.features, joints, action_indices, state_indices)
    unit = np.pi / 180 if degrees else 1.0
    episodes, torques, leads = {}, [], []
    for number, (_, features) in read_episodes(folder, info).items():
        read = {kind: features[key][:, at] * unit for kind, (key, at) in where.items()}
        q_des, q = read[COMMANDED], read["q"]
        check_positions(folder, number, joints, q_des, q, ranges)
        dq = read["dq"] if "dq" in read else _velocity(folder, number, q, info.fps)
        new = commands(q_des, q, dq, own, other)
        torques.append(np.abs(pd_torque(q_des, q, dq, own.kp, own.kd)))
        leads.append((np.abs(q_des - q).max(), np.abs(new - q).max()))
        episodes[number] = new / unit
    _check_torques(folder, joints, np.concatenate(torques), torque_limit)
    before, after = np.max(leads, axis=0)
    return Retargeted(episodes, where[COMMANDED][1], (float(before), float(after)))


def write_retargeted(found: Retargeted, source: Path, target: Path) -> None:
    """Copy a data set with the new commands and the statistics of its actions.

    Raises:
        ModuleNotFoundError: lerobot is not installed.
    """
    # it takes seconds, and only here it is needed
    from lerobot.datasets.compute_stats import aggregate_stats, compute_episode_stats

    shutil.copytree(source, target, dirs_exist_ok=True)
    feature = {ACTION: json.loads((source / "meta/info.json").read_text())["features"][ACTION]}
    actions: dict[int, list[np.ndarray]] = {}
    for path in sorted((target / "data").glob("*/*.parquet")):
        table = pq.read_table(path)
        action = np.stack(table[ACTION].to_numpy())
        episode, frame = table[_EPISODE].to_numpy(), table[_FRAME].to_numpy()
        for number in np.unique(episode):
            rows = np.flatnonzero(episode == number)
            # an episode may go on in another file; its commands are in the order of its frames
            first = frame[rows] - frame[rows].min() + _before(actions, number)
            action[np.ix_(rows, found.places)] = found.episodes[int(number)][first]
            actions.setdefault(int(number), []).append(action[rows[np.argsort(first)]])
        column = pa.array(action.tolist(), table.schema.field(ACTION).type)
        at = table.column_names.index(ACTION)
        pq.write_table(table.set_column(at, table.schema.field(ACTION), column), path)
    stats = {
        number: compute_episode_stats({ACTION: np.concatenate(parts)}, feature)
        for number, parts in actions.items()
    }
    _write_stats(target / "meta/stats.json", aggregate_stats(list(stats.values())))
    for path in sorted((target / "meta/episodes").glob("*/*.parquet")):
        _write_episode_stats(path, stats)


def _check_copied(folder: Path) -> None:
    """Whether all that is copied along can be, and what is rewritten be read.

    Raises:
        InputError: a pipe or a device is in the data set, or its statistics are none.
    """
    for path in sorted(folder.rglob("*")):
        if not path.is_dir():
            check_regular(path, RecordingError)
    path = folder / "meta/stats.json"
    if path.exists() and not isinstance(read_json(path, STATS, MOST_BYTES), dict):
        raise RecordingError(path, "the file", "no object", STATS)
    for path in sorted((folder / "meta/episodes").glob("*/*.parquet")):
        _episodes(path)


def _episodes(path: Path) -> pa.Table:
    with parsing(path, f"a Parquet table with {_EPISODE}"):
        table = pq.read_table(path)
        table[_EPISODE]
    return table


def _before(actions: dict[int, list[np.ndarray]], number: int) -> int:
    return sum(map(len, actions.get(int(number), [])))


def _write_stats(path: Path, stats: dict) -> None:
    content = read_json(path, STATS, MOST_BYTES) if path.exists() else {}
    content[ACTION] = {key: np.asarray(value).tolist() for key, value in stats[ACTION].items()}
    path.write_text(json.dumps(content, indent=4) + "\n")


def _write_episode_stats(path: Path, stats: dict[int, dict]) -> None:
    table = _episodes(path)
    for i, field in enumerate(table.schema):
        kind = field.name.removeprefix(f"stats/{ACTION}/")
        if kind != field.name:
            numbers = table[_EPISODE].to_pylist()
            values = [np.asarray(stats[number][ACTION][kind]).tolist() for number in numbers]
            table = table.set_column(i, field, pa.array(values, field.type))
    pq.write_table(table, path)


def _velocity(folder: Path, episode: int, q: np.ndarray, fps: float) -> np.ndarray:
    """(n, njoint) rad/s, by central differences."""
    if len(q) < 2:
        raise RecordingError(
            folder, f"episode {episode}", "one frame and no velocities", "two frames or more"
        )
    return np.gradient(q, 1 / fps, axis=0)


def check_positions(
    folder: Path,
    episode: int,
    joints: Sequence[str],
    q_des: np.ndarray,
    q: np.ndarray,
    ranges: np.ndarray,
) -> None:
    """Refuse positions where the joints cannot be, and commands that no controller gives."""
    for what, values, beyond in (
        ("command", q_des, MOST_LEAD_RAD), ("position", q, RANGE_TOLERANCE_RAD)
    ):  # fmt: skip
        bad = np.flatnonzero(~np.isfinite(values).all(axis=1))
        if len(bad):
            place = f"episode {episode}, frame {bad[0]}"
            raise RecordingError(folder, place, f"no finite {what}", "numbers")
        low = np.maximum(ranges[:, 0] - beyond, -MOST_RAD)
        high = np.minimum(ranges[:, 1] + beyond, MOST_RAD)
        outside = (values < low) | (values > high)
        if outside.any():
            frame, joint = np.argwhere(outside)[0]
            raise RecordingError(
                folder, f"episode {episode}, frame {frame}, joint {joints[joint]}",
                f"a {what} of {values[frame, joint]:.6g} rad",
                f"{low[joint]:.4g} to {high[joint]:.4g} rad, by the joint's range in the model, in "
                "the unit that the options say",
            )  # fmt: skip


def _check_torques(
    folder: Path, joints: Sequence[str], torque: np.ndarray, limit: np.ndarray
) -> None:
    """Refuse commands that no motor followed.

    Args:
        torque: (n, njoint) N·m that the law asks for, without sign.
    """
    beyond = (torque > limit).mean(axis=0)
    worst = int(np.argmax(beyond))
    if beyond[worst] > SATURATED:
        raise RecordingError(
            folder, f"joint {joints[worst]}",
            f"torques above its {limit[worst]:g} N·m in {100 * beyond[worst]:.0f} % of the frames",
            "commands that are positions, in the unit that the options say, and the gains that the "
            "robot had: without them torques cannot be reconstructed",
        )  # fmt: skip
