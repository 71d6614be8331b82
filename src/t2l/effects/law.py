"""What a learned torque is: where it acts, what it follows, and its curve."""

import re
from dataclasses import dataclass
from hashlib import sha256

import numpy as np

TORQUE, FRICTION, MOTOR = "torque", "friction", "motor"
INERTIA, LIMIT, TENDON = "inertia", "limit", "tendon"
SIGNED = (TORQUE, MOTOR, INERTIA, LIMIT, TENDON)  # whose values may be below zero
# optional columns of recordings, by what a law of them follows
COLUMNS = {"temperature": "temperature", "supply voltage": "supply_voltage"}
SESSION = "session time"  # what the log's clock shows, which recordings of a session share
GIVEN = (*COLUMNS, SESSION)  # what recordings tell, whatever the motion
PHASE = "phase"  # of what comes again: the log's clock, folded to lie between the ends of a curve
UNITS = {
    "constant": "",
    "acceleration": "rad/s²",
    "position": "rad",
    "velocity": "rad/s",
    "speed": "rad/s",
    "commanded torque": "N·m",
    "commanded torque size": "N·m",
    "load": "N·m",
    "time": "s",
    "session time": "s",
    "phase": "s",
    "temperature": "°C",
    "supply voltage": "V",
}
ALLOWED = {
    TORQUE: (
        "constant", "position", "velocity", "commanded torque", "load", "time", PHASE, *GIVEN,
    ),
    FRICTION: ("constant", "speed", "commanded torque size", "position", "time", *GIVEN),
    MOTOR: GIVEN,
    INERTIA: ("acceleration",),
    LIMIT: ("velocity",),
    TENDON: ("position", "velocity"),
}  # fmt: skip
OTHERS = ("position", "velocity")  # that may be another joint's
CLOCKS = ("time", SESSION)
ACTS = {
    FRICTION: "dry friction",
    MOTOR: "a share of the motor torque",
    LIMIT: "a limit of the motor torque",
}
VARIABLES = {
    "speed": "speed",
    "commanded torque size": "commanded torque's size",
    "load": "load by gravity",
    "time": "time since the start",
    SESSION: "time of the session",
}
# known effects that a curve of a joint's own variable has in it as its straight line
HAS = {
    (TORQUE, "commanded torque"): (
        "torque_constant", "torque_constant_drift", "torque_constant_temperature",
    ),
}  # fmt: skip
LONGEST_NAME = 80  # bound: of a plain name, to which a file's ending and a digest may be added
# numerics: points of a curve's length that is looked up linearly; 20 knots are exact to 1e-3
GRID = 513


@dataclass(frozen=True)
class Law:
    """What acts where: `kind` on `joint`, following a variable of joint `of`.

    A tendon acts on both.
    """

    kind: str
    joint: str
    follows: str
    of: str

    @property
    def name(self) -> str:
        """Plain, unique among laws."""
        others = f"_of_{self.of}" if self.of != self.joint else ""
        return f"learned_{self.kind}_{self.joint}_{self.follows.replace(' ', '_')}{others}"

    def plain_name(self, what: str) -> str:
        """A name that may be a file's, such as `formula_torque_elbow_position`.

        Args:
            what: it begins with.
        """
        wanted = self.name.replace("learned", what, 1)
        plain = re.sub(r"[^A-Za-z0-9_]", "_", wanted)[:LONGEST_NAME]
        # joints of any names may be alike in the letters that are left
        return plain if plain == wanted else f"{plain}_{sha256(wanted.encode()).hexdigest()[:8]}"

    @property
    def words(self) -> str:
        """It without its curve: "a torque on elbow that follows its position"."""
        if self.follows == PHASE:
            return f"a torque on {self.joint} that repeats by the clock"
        if self.follows == "constant":
            what = "constant dry friction" if self.kind == FRICTION else "a constant torque"
            return f"{what} on {self.joint}"
        if self.kind == TENDON:
            what = {"position": "positions", "velocity": "velocities"}[self.follows]
            both = f"{self.joint} and {self.of} together"
            return f"a torque on {both} that follows their {what}"
        its = "the" if self.follows in CLOCKS else "its"
        variable = f"{its} {VARIABLES.get(self.follows, self.follows)}"
        return f"{ACTS.get(self.kind, 'a torque')} on {self.joint} that follows {variable}"

    @property
    def unit(self) -> str:
        """Of the variable."""
        return UNITS[self.follows]

    @property
    def torque_unit(self) -> str:
        """Of the curve's values: N·m, or none of a share."""
        return "" if self.kind == MOTOR else "N·m"

    @property
    def given(self) -> bool:
        """Whether the recordings tell its variable, whatever the motion."""
        return self.follows in GIVEN

    @property
    def column(self) -> str | None:
        """The optional column of the recordings that it follows, if it follows one."""
        return COLUMNS.get(self.follows)

    @property
    def needs(self) -> tuple[str, ...]:
        """Optional columns that the recordings must have, as `Effect.needs`."""
        return (self.column,) if self.column else ()


@dataclass(frozen=True)
class Curve:
    """A law with its values.

    Attributes:
        at: (n,) values of the variable, increasing.
        torque: (n,) N·m there, or shares of the motor torque (`Law.torque_unit`). Beyond the ends
            the curve goes on straight, to either side as far as it is long; then the last value
            holds, so that no torque grows without bound. A curve over a phase begins anew there.
        ratio: of a tendon: the lever arm at joint `of` over that at `joint`.
    """

    law: Law
    at: tuple[float, ...]
    torque: tuple[float, ...]
    ratio: float = 0.0

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """The torque at x: a monotone cubic between the values."""
        if len(self.at) < 2:
            return np.full(np.shape(x), self.torque[0])
        if self.law.kind == INERTIA:
            return -self.inertia * x
        # only here: importing it takes a third of a second
        from scipy.interpolate import PchipInterpolator

        x = np.clip(x, *self.reach)
        inside = np.clip(x, self.at[0], self.at[-1])
        first, last = (np.diff(self.torque) / np.diff(self.at))[[0, -1]]
        # slopes may be too small to divide by
        with np.errstate(over="ignore"):
            value = PchipInterpolator(self.at, self.torque)(inside)
        value = value + np.where(x < inside, first, last) * (x - inside)
        return np.maximum(value, 0.0) if self.law.kind == FRICTION else value

    @property
    def reach(self) -> tuple[float, float]:
        """Ends of what the curve says anything of."""
        if self.law.follows == PHASE:
            return self.at[0], self.at[-1]
        length = self.at[-1] - self.at[0]
        return self.at[0] - length, self.at[-1] + length

    def table(self) -> tuple[np.ndarray, np.ndarray]:
        """(g,) equally spaced values over its reach, and the torque there, to look up linearly."""
        grid = np.linspace(*self.reach, 3 * (GRID - 1) + 1)
        return grid, self(grid)

    @property
    def inertia(self) -> float:
        """kg·m² that a curve over the acceleration stands for: minus its slope."""
        return -(self.torque[-1] - self.torque[0]) / (self.at[-1] - self.at[0])
