"""The motions that an experiment is chosen from: shapes, moved joints, sizes and gains."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from t2l.hardware import excitation_kinds
from t2l.hardware.limits import POSITION_MARGIN_RAD
from t2l.hardware.motion import Motion
from t2l.hardware.plan import Setup
from t2l.recordings.recording import Recording

# tuned: of the largest motion: what saturates or slips in the one does not in the other
SMALL = 1 / 3
FASTEST_HZ = 5.0  # bound: above, a position loop hardly follows
SAMPLES_PER_PERIOD = 10  # bound: of the fastest sine: fewer are no sine to who is commanded
SWEEPS = 2  # tuned: of the slow triangle, four reversals
SEED = 0  # statistics: of the random phases


@dataclass(frozen=True)
class Candidate:
    """A motion that may be chosen.

    Attributes:
        name: of its recording.
        excitation: its keys as a configuration of recordings has them, amplitudes apart.
        amplitude_rad: (njoint,).
        kp, kd: (njoint,) N·m/rad and N·m·s/rad.
        moved: what it moves, `all` or `joint2`; `shape` how.
    """

    name: str
    excitation: Mapping[str, Any]
    amplitude_rad: np.ndarray
    kp: np.ndarray
    kd: np.ndarray
    moved: str
    shape: str

    def scaled(self, factor: np.ndarray | float) -> "Candidate":
        """The same with other amplitudes."""
        return replace(self, amplitude_rad=factor * self.amplitude_rad)

    def section(self) -> dict[str, Any]:
        """The keys of its excitation, rounded to what is written."""
        keys = {k: list(v) if isinstance(v, list) else v for k, v in self.excitation.items()}
        return {**keys, "amplitude_rad": np.round(self.amplitude_rad, 5).tolist()}

    def motion(self, setup: Setup) -> Motion:
        """What `t2l record` would command."""
        rate = setup.command_rate_hz
        offsets, notes = excitation_kinds.offsets(
            self.section(), setup.path, len(setup.robot.joints), rate
        )
        return Motion(self.name, setup.start + offsets, rate, self.kp, self.kd, notes)


def library(setup: Setup, duration_s: float, most_rad: float) -> list[Candidate]:
    """Every shape, of all joints together and of each alone, under every pair of gains.

    Amplitudes are the largest that the joints' ranges leave; `t2l.design.safety` makes them safe.

    Args:
        duration_s: of each motion.
        most_rad: largest offset from the start.

    Raises:
        RecordingError: the gains of the configuration are missing or wrong.
    """
    njoint = len(setup.robot.joints)
    low, high = setup.robot.position_limit.T
    room = np.minimum(setup.start - low, high - setup.start) - POSITION_MARGIN_RAD
    most = np.clip(room, 0.0, most_rad)
    groups = {"all": np.ones(njoint)}
    if njoint > 1:
        groups |= {f"joint{i + 1}": np.eye(njoint)[i] for i in range(njoint)}
    return [
        Candidate(
            "_".join(filter(None, (cell, moved, shape, "small" if size < 1 else ""))),
            keys, size * most * members, kp, kd, moved, shape,
        )
        for cell, (kp, kd) in setup.gains().items()
        for moved, members in groups.items()
        for shape, keys in _shapes(duration_s, setup.command_rate_hz)
        for size in ((1.0, SMALL) if moved == "all" and shape != "hold" else (1.0,))
        if (members * most).any()
    ]  # fmt: skip


def shortest_s(rate_hz: float) -> float:
    """The shortest motions whose slowest sine commands at a rate can follow."""
    return SWEEPS / _fastest_hz(rate_hz)


def _fastest_hz(rate_hz: float) -> float:
    return min(FASTEST_HZ, rate_hz / SAMPLES_PER_PERIOD)


def _shapes(duration_s: float, rate_hz: float) -> Iterator[tuple[str, dict[str, Any]]]:
    """Excitations by name, without amplitudes."""
    fastest = _fastest_hz(rate_hz)
    slowest = SWEEPS / duration_s
    ramp = min(1.0, duration_s / 4)

    def keys(kind: str, **more: Any) -> dict[str, Any]:
        return {"kind": kind, "duration_s": duration_s, "ramp_s": ramp, **more}

    slow = [slowest * k for k in (1, 2, 3, 5) if slowest * k <= fastest]
    fast = np.geomspace(max(1.0, slowest), fastest, 5) if fastest > max(1.0, slowest) else slow
    yield "slow_multisine", keys("multisine", frequencies_hz=_rounded(slow), seed=SEED)
    yield "fast_multisine", keys("multisine", frequencies_hz=_rounded(fast), seed=SEED)
    yield "chirp", keys("chirp", from_hz=round(slowest, 4), to_hz=round(fastest, 4))
    yield "moves", keys("point_to_point", move_s=1.0, dwell_s=0.5)
    # bound: of a position loop
    yield "quick_moves", keys("point_to_point", move_s=0.4, dwell_s=0.6)
    yield "triangle", keys("triangle", frequency_hz=round(slowest, 4))
    yield "hold", keys("hold")


def _rounded(values) -> list[float]:
    return [round(float(value), 4) for value in values]


def recording(setup: Setup, motion: Motion, rows_per_command: int = 1) -> Recording:
    """A recording of a motion before it was made: as measured it has the commands themselves."""
    q_des = np.repeat(motion.q_des, rows_per_command, axis=0)
    return Recording(
        name=motion.name,
        path=None,
        robot=setup.robot.name,
        joints=setup.robot.joints,
        kp=motion.kp,
        kd=motion.kd,
        command_rate_hz=motion.rate_hz,
        control_rate_hz=float(setup.features.control_rate_hz),
        gravity_compensation=setup.features.gravity_compensation,
        time=np.arange(len(q_des)) / (motion.rate_hz * rows_per_command),
        q_des=q_des,
        # begins at rest, whatever slope the commands have
        q=np.repeat(q_des[:1], len(q_des), axis=0),
    )
