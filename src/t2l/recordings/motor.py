"""A drive that is a DC motor under a voltage: what its duty and its gains are in N·m.

    duty = clip(Kp (q_des − q) + Kd (dq_des − q̇), −1, 1)
    τ = kt / R (duty V − kt q̇),   kt as seen at the joint, gear and all

So at a supply V the torque is that of gains Kp V kt/R and Kd V kt/R, cut at the torque V kt/R at
stall, and a damping kt²/R by back-EMF, which is there whatever the loop does, as long as the motor
is on.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from t2l.errors import RecordingError
from t2l.recordings.control import DUTY
from t2l.recordings.recording import Recording, held


@dataclass(frozen=True, eq=False)
class Motor:
    """One for each joint; (njoint,) each.

    Attributes:
        kt: N·m/A, or V·s/rad, at the joint.
        resistance: Ω.
        supply: V; of a logged one the median over the recording.
        logged: whether the column `supply_voltage` says how it changes.
    """

    kt: np.ndarray
    resistance: np.ndarray
    supply: np.ndarray
    logged: bool = False

    @property
    def stall(self) -> np.ndarray:
        """N·m at rest under full duty, (njoint,)."""
        return self.kt * self.supply / self.resistance

    @property
    def back_emf(self) -> np.ndarray:
        """N·m·s/rad, (njoint,)."""
        return self.kt**2 / self.resistance


def in_newton_metres(
    signals: Mapping[str, np.ndarray | None], metadata: Mapping[str, Any], path: Path
) -> dict[str, Any]:
    """Signals and metadata of a table as arguments of `Recording`: gains and duties in N·m.

    Args:
        signals: by attribute of `Recording`; of `control: duty`, tau_ff is the duty.
        path: the table, for messages.

    Raises:
        RecordingError: a duty beyond full, or a column that the motor needs, or does not take.
    """
    arguments = {**metadata, **signals}
    motor = arguments["motor"]
    if signals.get("q_des") is None:
        arguments["q_des"] = held(signals["q"])
    if motor is None:
        return arguments
    given = arguments["tau_ff"]
    if given is not None and arguments["control"] != DUTY:
        raise RecordingError(
            path, f"column tau_ff.{arguments['joints'][0]}", "a torque, where the YAML has a motor "
            "under a voltage", "no such column: it takes duty",
        )  # fmt: skip
    if motor.logged:
        voltage = arguments["supply_voltage"]
        if voltage is None or np.isnan(voltage).all(axis=0).any():
            raise RecordingError(
                path, "column supply_voltage", "nothing", "voltages in V, as motor.supply in the "
                "YAML names that column",
            )  # fmt: skip
        motor = replace(motor, supply=np.nanmedian(voltage, axis=0))
    if given is not None:
        beyond = np.argwhere(np.abs(given) > 1)
        if len(beyond):
            row, joint = beyond[0]
            raise RecordingError(
                path, f"row {row + 1}, column duty.{arguments['joints'][joint]}",
                f"{given[row, joint]:g}", "a share of the supply voltage, from -1 to 1",
            )  # fmt: skip
        arguments["tau_ff"] = given * motor.stall
    gains = {key: arguments[key] * motor.stall for key in ("kp", "kd")}
    return {**arguments, **gains, "motor": motor}


def of_table(recording: Recording) -> Recording:
    """With gains and duties as a table and its YAML hold them."""
    motor = recording.motor
    if motor is None:
        return recording
    duty = None if recording.tau_ff is None else recording.tau_ff / motor.stall
    return replace(
        recording, kp=_rounded(recording.kp / motor.stall), kd=_rounded(recording.kd / motor.stall),
        tau_ff=duty,
    )  # fmt: skip


def _rounded(values: np.ndarray) -> np.ndarray:
    """To what a product and a quotient keep of them."""
    return np.array([float(f"{value:.13g}") for value in values])
