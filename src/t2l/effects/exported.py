"""A robot under its controller as plain MJCF, while effects write themselves into it.

MuJoCo's Euler integrator holds the torque of a position actuator for one timestep, the loop's
period h. Its position leads by half a step of velocity, q' = q + h/2 q̇, so that an actuator with
the damping Kd − Kp h/2 at q' gives the torque Kp (q_des − q) − Kd q̇ of the loop.
"""

import dis
import inspect
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import FunctionType

import mujoco
import numpy as np

from t2l.errors import EffectError

# where callbacks act, in the order of the signals
CONTROLLER, MOTOR, JOINT = "controller", "motor", "joint"
SIGNALS = (CONTROLLER, MOTOR, JOINT)


@dataclass(frozen=True)
class Callback:
    """A function that runs before each timestep, see `Exported.call`.

    Attributes:
        stateless: whether it remembers nothing.
    """

    effect: str
    function: Callable
    joints: tuple[int, ...]
    values: Mapping[str, np.ndarray]
    on: str = JOINT
    element: Callable[[], None] | None = None
    stateless: bool = False

    @property
    def sources(self) -> dict[str, str]:
        """Texts by name: what it uses of its module, and its own."""
        return _sources(self.function)


@dataclass
class Exported:
    """What becomes MJCF and a callback.

    Attributes:
        spec: the plant with what effects add to its structure, without actuators; names as in the
            robot's own file.
        joints: that are driven.
        period_s: of the control loop, and of the timestep.
        gravity_compensation: whether the loop cancels gravity.
        kp, kd: (njoint,) N·m/rad and N·m·s/rad that the loop really uses.
        known_to_loop: the plant before effects, whose weight gravity compensation carries.
        limit: (njoint,) N·m, of the motor torque, gravity compensation included.
        constant: (njoint,) N·m on the joint, which the actuator adds.
        encoder_offset: (njoint,) rad, measured minus true position.
        delay_s, lowpass_s: (njoint,) s, of commands: dead time, and time constant.
        callbacks: for what MuJoCo has no element of.
        read_too: (effect, joint, name, share) of a joint of the MJCF of whose position the encoder
            of a driven joint adds a share to that joint's own.
        other_weight: effects that change gravity or masses, of which compensation knows nothing.
        of_log: effects of recordings, not of the robot.
        log_lead_s: by how much commands are in force before their time in recordings.
        lost: (effect, why) of what is not carried, wholly or in part.
    """

    spec: mujoco.MjSpec
    joints: tuple[str, ...]
    period_s: float
    gravity_compensation: bool
    kp: np.ndarray
    kd: np.ndarray
    known_to_loop: mujoco.MjModel
    limit: np.ndarray = field(init=False)
    constant: np.ndarray = field(init=False)
    encoder_offset: np.ndarray = field(init=False)
    delay_s: np.ndarray = field(init=False)
    lowpass_s: np.ndarray = field(init=False)
    callbacks: list[Callback] = field(default_factory=list)
    read_too: list[tuple[str, int, str, float]] = field(default_factory=list)
    other_weight: list[str] = field(default_factory=list)
    of_log: list[str] = field(default_factory=list)
    log_lead_s: float = 0.0
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
        on: str = JOINT,
        element: Callable[[], None] | None = None,
    ) -> None:
        """Let the exported robot call ``function(robot, joints, values)`` before each timestep.

        Its text is copied, and that of the functions and numbers of its module that it uses; it
        may use numpy as np beside. `robot` has, by joint,

        - at the loop's tick, in rad and rad/s: `target`, `q` and `dq` that the loop sees,
          `position` and `velocity` of the joint, as model.xml counts them; `kp`, `kd`;
        - in the middle of the step: `angle` (rad without the encoder's offset) and `rate` (rad/s,
          if the joint goes on as before), and the torques in N·m `load` and `gravity` (to hold the
          links in motion, and at rest), `passive` (springs and dampers);
        - to change: `motor` (N·m that the motor gives, as far as the signal has come);
        - to add to: `torque` (N·m), `friction` (N·m of dry friction), `damping` (N·m·s/rad),
          `stiffness` (N·m/rad) and `pull` (N·m that it gives at zero).

        `torques_at_rest()` and `given_at_rest(demand)` are the torques on joints that rest, and
        what motors make of a demand there, N·m by joint, of what remembers nothing. Of its own it
        has `state`, a dict that is empty at the start. `tick` counts, `period_s` is the time from
        tick to tick.

        Args:
            on: CONTROLLER, MOTOR or JOINT: it changes what the loop computes, what the motor makes
                of that, or adds to what the joint feels. They run in this order, and in that of
                `Effect.order`.
            element: writes it into the MJCF instead. It is called unless a callback on the signal
                of a joint comes before it.
        """
        joints = tuple(map(int, joints))
        self.callbacks.append(Callback(effect, function, joints, dict(values), on, element))

    def finish(self) -> None:
        """Write what the MJCF can hold, keep the other callbacks in their order."""
        kept, changed = [], {j for _, j, *_ in self.read_too}
        if self.compensates_another:
            changed |= set(range(len(self.joints)))
        for call in sorted(self.callbacks, key=lambda call: SIGNALS.index(call.on)):
            if call.element is not None and not changed & set(call.joints):
                call.element()
                continue
            kept.append(call)
            if call.on != JOINT:
                changed |= set(call.joints)
        self.callbacks = kept

    @property
    def compensates_another(self) -> bool:
        """Whether gravity compensation carries another weight than that of the model."""
        return self.gravity_compensation and bool(self.other_weight)

    @property
    def by_callback(self) -> set[str]:
        """Effects that MuJoCo has no element of, or not for all of it."""
        by_call = {call.effect for call in self.callbacks} | {
            effect for effect, *_ in self.read_too
        }
        return by_call | set(self.other_weight if self.compensates_another else ())

    def cannot_carry(self, effect: str, why: str) -> None:
        """Say so in what is written."""
        self.lost.append((effect, why))


def _sources(function: FunctionType) -> dict[str, str]:
    found: dict[str, str] = {}
    for step in dis.get_instructions(function):
        name, used = step.argval, None
        if step.opname == "LOAD_GLOBAL" and name != "np":
            used = function.__globals__.get(name)
        if isinstance(used, FunctionType):
            found |= {} if used is function else _sources(used)
        elif isinstance(used, int | float):
            # a number that is not finite has no name of its own
            number = repr(used) if math.isfinite(used) else f'float("{used}")'
            found[name] = f"{name} = {number}\n"
        elif used is not None:
            raise EffectError(
                f"{inspect.getfile(function)}: {function.__name__} is to be exported, and uses "
                f"{name}; allowed: its arguments, np, functions and numbers of its module"
            )
    return {**found, function.__name__: inspect.getsource(function)}
