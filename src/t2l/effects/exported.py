"""A robot under its controller as plain MJCF, while effects write themselves into it.

MuJoCo's Euler integrator holds the torque of a position actuator for one timestep, the loop's
period h. Its position leads by half a step of velocity, q' = q + h/2 q̇, so that an actuator with
the damping Kd − Kp h/2 at q' gives the torque Kp (q_des − q) − Kd q̇ of the loop.
"""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import mujoco
import numpy as np


@dataclass(frozen=True)
class Callback:
    """A function that runs before each timestep, see `Exported.call`."""

    effect: str
    function: Callable
    joints: tuple[int, ...]
    values: Mapping[str, np.ndarray]

    @property
    def source(self) -> str:
        """Its text."""
        return inspect.getsource(self.function)


@dataclass
class Exported:
    """What becomes MJCF and a callback.

    Attributes:
        spec: the plant, without actuators; names as in the robot's own file.
        joints: that are driven.
        period_s: of the control loop, and of the timestep.
        gravity_compensation: whether the loop cancels gravity.
        kp, kd: (njoint,) N·m/rad and N·m·s/rad that the loop really uses.
        limit: (njoint,) N·m, of the motor torque, gravity compensation included.
        constant: (njoint,) N·m that the actuator adds.
        encoder_offset: (njoint,) rad, measured minus true position.
        delay_s, lowpass_s: (njoint,) s, of commands: dead time, and time constant.
        callbacks: for what MuJoCo has no element of.
        lost: (effect, why) of what is not carried, wholly or in part.
    """

    spec: mujoco.MjSpec
    joints: tuple[str, ...]
    period_s: float
    gravity_compensation: bool
    kp: np.ndarray
    kd: np.ndarray
    limit: np.ndarray = field(init=False)
    constant: np.ndarray = field(init=False)
    encoder_offset: np.ndarray = field(init=False)
    delay_s: np.ndarray = field(init=False)
    lowpass_s: np.ndarray = field(init=False)
    callbacks: list[Callback] = field(default_factory=list)
    lost: list[tuple[str, str]] = field(default_factory=list)

    def __post_init__(self) -> None:
        n = len(self.joints)
        self.kp, self.kd = np.array(self.kp, float), np.array(self.kd, float)
        self.limit, self.constant = np.full(n, np.inf), np.zeros(n)
        self.delay_s, self.lowpass_s = np.zeros(n), np.zeros(n)
        self.encoder_offset = np.zeros(n)

    def each(self, joints: np.ndarray) -> list[mujoco.MjsJoint]:
        """The elements of `joints`, to write attributes into."""
        return [self.spec.joint(self.joints[j]) for j in joints]

    def call(
        self,
        effect: str,
        function: Callable,
        joints: np.ndarray,
        values: Mapping[str, np.ndarray],
    ) -> None:
        """Let the exported robot call ``function(robot, joints, values)`` before each timestep.

        Its text is copied: it may use nothing but its arguments and numpy as np. `robot` has, by
        joint, `angle` and `dq` (rad without the encoder's offset, rad/s), `motor` (N·m that its
        actuator gives), `load` and `gravity` (N·m that it takes to hold the links in motion, and
        at rest), and to write: `torque` (N·m that is added) and `friction` (N·m that is added to
        dry friction); `period_s`.
        """
        self.callbacks.append(Callback(effect, function, tuple(map(int, joints)), dict(values)))

    def cannot_carry(self, effect: str, why: str) -> None:
        """Say so in what is written."""
        self.lost.append((effect, why))
