"""Recordings from ROS 2 bags and MCAP files, by a mapping.

A mapping is a YAML with the keys of a recording's YAML and these:

    topics:
      state: /joint_states                       # sensor_msgs/JointState
      command: /arm_controller/joint_trajectory  # trajectory_msgs/JointTrajectory,
    names: [arm_1, arm_2]                        # std_msgs/Float64MultiArray or JointState
    clock: header                                # or received

`names` are the bag's names of `joints`, where they differ. Stamps are those of the headers, so that
the network's jitter is not in them; a message without a stamp has the time at which it was
received. Times are shifted to begin with the first command. Whatever is left out is said, with why.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from t2l.documents import check_regular, read_yaml
from t2l.errors import RecordingError
from t2l.recordings.checks import check_samples, check_ticks
from t2l.recordings.control import POSITION
from t2l.recordings.importers.bag_messages import (
    NANO,
    TRAJECTORY,
    Received,
    accepted,
    in_order,
    say,
)
from t2l.recordings.importers.trajectories import Point, held_commands
from t2l.recordings.keys import checked
from t2l.recordings.metadata import Metadata
from t2l.recordings.recording import Recording
from t2l.typed import Typed, describe, suggestion
from t2l.waiting import told_if_slow

STATE = "sensor_msgs/msg/JointState"
NUMBERS = "std_msgs/msg/Float64MultiArray"
COMMANDS = (TRAJECTORY, NUMBERS, STATE)


class Topics(Typed):
    """Where states and commands are."""

    state: Annotated[str, Field(min_length=1, description=f"a topic of {STATE}")]
    command: Annotated[str, Field(min_length=1, description=f"a topic of {' or '.join(COMMANDS)}")]


class BagMappingFile(Metadata):
    """A mapping as it is written: a recording's YAML, and where the bag has what it needs."""

    topics: dict[str, Any]
    names: list[str] | None = None
    clock: Literal["header", "received"] = "header"


@dataclass(frozen=True)
class BagMapping:
    """A checked mapping file; `names` are the joints' in the bag."""

    path: Path
    metadata: Mapping[str, Any]
    state: str
    command: str
    names: tuple[str, ...]
    by_header: bool


def read_bag_mapping(path: Path | str, **overrides: Any) -> BagMapping:
    """Read and check a mapping file.

    Args:
        overrides: values that replace keys of the file, such as ``kp=64``.

    Raises:
        RecordingError: a key is missing, unknown or wrong.
    """
    path = Path(path)
    values = read_yaml(path, "a mapping, which says which topics a bag's commands and states are")
    if isinstance(values, dict):
        values = {**values, **overrides}
    found = checked(BagMappingFile, values, path)
    if found.control != POSITION:
        raise RecordingError(
            path, "key control", describe(found.control), f"{POSITION}: what bags are read for"
        )
    topics = checked(Topics, found.topics, path, "topics.")
    names = tuple(found.names or found.joints)
    if len(names) != len(found.joints) or len(set(names)) < len(names):
        allowed = f"{len(found.joints)} different names, one for each joint"
        raise RecordingError(path, "key names", describe(list(names)), allowed)
    return BagMapping(
        path, found.arguments(path), topics.state, topics.command, names, found.clock == "header"
    )


def read_bag(bag: Path | str, mapping: BagMapping) -> Recording:
    """The recording that a mapping makes of a bag: a folder of ROS 2, or an .mcap file.

    Raises:
        RecordingError: it cannot be read, a topic or joint is not in it, or it is no recording.
        ModuleNotFoundError: the package rosbags is not installed.
    """
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    bag = Path(bag)
    if not bag.exists():
        raise RecordingError(bag, "the bag", "nothing", "a folder of a ROS 2 bag, or an .mcap")
    for file in sorted(bag.iterdir()) if bag.is_dir() else [bag]:
        if not file.is_dir():
            check_regular(file, RecordingError)
    states, commands = [], []
    try:
        # bags of SQLite do not hold the definitions of their messages
        with (
            told_if_slow(f"bag {bag}, to be read"),
            AnyReader([bag], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader,
        ):
            connections = _connections(reader.connections, mapping.state, (STATE,), bag, mapping)
            commanding = _connections(reader.connections, mapping.command, COMMANDS, bag, mapping)
            if mapping.command != mapping.state:
                connections += commanding
            for connection, received, raw in reader.messages(connections=connections):
                message = reader.deserialize(raw, connection.msgtype)
                stamp = _stamp(message, received, mapping.by_header)
                if connection.topic == mapping.state:
                    states.append(Received(stamp, received, connection.msgtype, message))
                if connection.topic == mapping.command:
                    commands.append(Received(stamp, received, connection.msgtype, message))
    except RecordingError:
        raise
    # what a damaged file makes of its many parsers: each has errors of its own
    except Exception as error:
        reason = " ".join(str(error).split())[:200] or type(error).__name__  # format: characters
        raise RecordingError(
            bag, "the bag", f"what cannot be read ({reason})", "a ROS 2 bag or an .mcap"
        ) from None
    return _recording(bag, states, commands, mapping)


def _connections(connections: Iterable, topic: str, types, bag: Path, mapping: BagMapping) -> list:
    found = [connection for connection in connections if connection.topic == topic]
    if not found:
        topics = sorted({connection.topic for connection in connections})
        shown = f"nothing{suggestion(topic, topics)}"
        where = f"topic {topic}, which {mapping.path} names"
        raise RecordingError(bag, where, shown, f"one of {', '.join(topics)}")
    for connection in found:
        if connection.msgtype not in types:
            raise RecordingError(bag, f"topic {topic}", connection.msgtype, " or ".join(types))
    return found


def _stamp(message: Any, received: int, by_header: bool) -> float:
    """ns; of the header's stamp where there is one."""
    header = getattr(message, "header", None)
    if by_header and header is not None and (header.stamp.sec or header.stamp.nanosec):
        return header.stamp.sec * 10**9 + header.stamp.nanosec  # format: ns
    return received


def _recording(
    bag: Path, states: list[Received], commands: list[Received], mapping: BagMapping
) -> Recording:
    for kind, found in (("state", states), ("command", commands)):
        if not found:
            topic = getattr(mapping, kind)
            raise RecordingError(bag, f"topic {topic}", "no message", f"at least one {kind}")
    commands = accepted(bag, mapping.command, commands)
    # before they become floating-point numbers, which hold no nanoseconds since 1970
    origin = min(one.stamp for one in (*states, *commands))
    measured = _measured(bag, states, origin, mapping)
    latest = in_order(bag, mapping.command, commands)
    began, ended = (latest[0].stamp - origin) * NANO, measured["time"][-1]
    fastest = max(mapping.metadata[f"{loop}_rate_hz"] for loop in ("control", "command"))
    where = f"topics {mapping.command} and {mapping.state}, the first command to the last state"
    check_ticks(ended - began, fastest, bag, where)
    points = [
        point
        for one in latest
        for point in _points(bag, (one.stamp - origin) * NANO, one.kind, one.message, mapping)
    ]
    first = measured["q"][0]
    command_time, command = held_commands(points, first, mapping.metadata["command_rate_hz"], ended)
    time = np.unique(np.concatenate([command_time, measured["time"]]))
    time = time[(time >= command_time[0]) & (time <= ended)]
    if len(time) < 2:
        raise RecordingError(
            bag, "the clock", "states and commands at different times",
            "stamps of one clock; try clock: received",
        )  # fmt: skip
    held = np.searchsorted(command_time, time, side="right") - 1
    at = np.searchsorted(time, measured["time"])
    inside = measured["time"] >= time[0]
    early, late = np.sum(~inside), sum((one.stamp - origin) * NANO > ended for one in latest)
    say(bag, mapping.state, early, len(inside), "from before the first command")
    say(bag, mapping.command, late, len(latest), "from after the last state")
    signals = {}
    for kind in ("q", "dq", "tau"):
        values = measured[kind]
        signals[kind] = None
        if values is not None:
            signals[kind] = np.full((len(time), values.shape[1]), np.nan)
            signals[kind][at[inside]] = values[inside]
    recording = Recording(
        name=bag.stem, path=bag, time=time - time[0], q_des=command[held], **signals,
        **mapping.metadata,
    )  # fmt: skip
    try:
        return check_samples(recording)
    except RecordingError as error:
        where = f"{error.where}, as mapped by {mapping.path}"
        raise RecordingError(bag, where, error.found, error.allowed) from None


def _measured(
    bag: Path, states: list[Received], origin: int, mapping: BagMapping
) -> dict[str, Any]:
    """Times (n,) s, increasing, and q, dq, tau (n, njoint); dq and tau None where not published.

    A driver may publish several groups of joints on one topic: messages without ours are skipped.
    """
    ours = [one for one in states if set(mapping.names) <= set(one.message.name)]
    if not ours:
        seen = max((list(one.message.name) for one in states), key=len)
        absent = next((n for n in mapping.names if n not in seen), mapping.names[0])
        raise RecordingError(
            bag, f"topic {mapping.state}, joint {absent}", f"nothing{suggestion(absent, seen)}",
            ", ".join(seen),
        )  # fmt: skip
    why = f"without {', '.join(mapping.names)}"
    say(bag, mapping.state, len(states) - len(ours), len(states), why)
    latest = in_order(bag, mapping.state, ours)
    rows = [_row(one.message, mapping.names) for one in latest]
    q, dq, tau = (np.array(parts) for parts in zip(*rows, strict=True))
    return {
        "time": np.array([(one.stamp - origin) * NANO for one in latest]),
        "q": q,
        "dq": None if np.isnan(dq).all() else dq,
        "tau": None if np.isnan(tau).all() else tau,
    }


def _row(message: Any, names: Sequence[str]) -> list[np.ndarray]:
    """Positions, velocities and efforts of the joints, (njoint,) each, NaN if not published."""
    published = list(message.name)
    where = [published.index(name) for name in names]
    return [
        np.asarray(part, float)[where]
        if len(part) == len(published)
        else np.full(len(where), np.nan)
        for part in (message.position, message.velocity, message.effort)
    ]


def _points(bag: Path, time: float, kind: str, message: Any, mapping: BagMapping) -> list[Point]:
    """What one message commands."""
    place = f"topic {mapping.command}"
    if kind == NUMBERS:
        if len(message.data) != len(mapping.names):
            allowed = f"{len(mapping.names)}, one for each joint in their order"
            raise RecordingError(bag, place, f"{len(message.data)} numbers", allowed)
        return [Point(time, time, np.array(message.data, float), None)]
    names = list(message.name if kind == STATE else message.joint_names)
    missing = [name for name in mapping.names if name not in names]
    if missing:
        shown = f"nothing{suggestion(missing[0], names)}"
        raise RecordingError(bag, f"{place}, joint {missing[0]}", shown, ", ".join(names))
    where = [names.index(name) for name in mapping.names]
    if kind == STATE:
        return [Point(time, time, _each(bag, place, message.position, names, where), None)]
    return [
        Point(
            time,
            time + point.time_from_start.sec + point.time_from_start.nanosec * NANO,
            _each(bag, place, point.positions, names, where),
            np.asarray(point.velocities, float)[where]
            if len(point.velocities) == len(names)
            else None,
        )
        for point in message.points
    ]


def _each(bag: Path, place: str, values: Any, names: list[str], where: list[int]) -> np.ndarray:
    if len(values) != len(names):
        found = f"{len(values)} positions of {len(names)} joints"
        raise RecordingError(bag, place, found, "a position for each joint")
    return np.asarray(values, float)[where]
