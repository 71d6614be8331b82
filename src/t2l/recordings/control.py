"""What a drive is commanded, by `control` of a recording's YAML: its columns and its gains.

position   τ = Kp (q_des − q) + Kd (dq_des − q̇) + tau_ff
velocity   τ = Kd (dq_des − q̇) + tau_ff
torque     τ = tau_des
duty       τ = kt / R (duty V − kt q̇), of a motor under a voltage, see `t2l.recordings.motor`
"""

from dataclasses import dataclass, field

# format: of the key `control`
POSITION, VELOCITY, TORQUE, DUTY = "position", "velocity", "torque", "duty"

# columns of what is measured, which are attributes of a recording of the same name
MEASURED = {
    "q": "rad", "dq": "rad/s", "tau": "N·m", "current": "A", "supply_voltage": "V",
    "temperature": "°C", "torque_enabled": "0 or 1",
}  # fmt: skip


@dataclass(frozen=True)
class Control:
    """What belongs to a kind of control.

    Attributes:
        commands: the columns of commands, each with the attribute of `Recording` that it is; the
            first one must be there.
        gains: the keys of the YAML that it takes; those it does not are zero.
    """

    commands: dict[str, str]
    gains: tuple[str, ...] = field(default=())

    @property
    def command(self) -> str:
        """The column that must be there."""
        return next(iter(self.commands))

    @property
    def columns(self) -> dict[str, str]:
        """Every column of a joint, with the attribute of `Recording` that it is."""
        return self.commands | {name: name for name in MEASURED}

    def column(self, attribute: str) -> str:
        """What the table calls an attribute of `Recording`."""
        return next((c for c, a in self.columns.items() if a == attribute), attribute)


# format: of tables
CONTROLS = {
    POSITION: Control(
        {"q_des": "q_des", "dq_des": "dq_des", "tau_ff": "tau_ff"}, gains=("kp", "kd")
    ),
    VELOCITY: Control({"dq_des": "dq_des", "tau_ff": "tau_ff"}, gains=("kd",)),
    TORQUE: Control({"tau_des": "tau_ff"}),
    DUTY: Control({"duty": "tau_ff"}),
}
UNITS = {"q_des": "rad", "dq_des": "rad/s", "tau_ff": "N·m", "tau_des": "N·m"}
UNITS |= {"duty": "-1 to 1"} | MEASURED
