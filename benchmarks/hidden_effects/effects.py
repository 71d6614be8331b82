"""Physical effects that a recording may hide, each a small class with one explicit equation.

An effect overrides the hooks of `HiddenEffect` that it needs: it changes the generator's own
model, a signal on the way from command to motor torque, or adds a torque at every physics step.

Magnitudes are one number for all joints or a mapping from joint to number, which restricts the
effect to the joints named. Torques act on the motor's side of a joint, which is the joint itself
unless `JointFlexibility` or `Backlash` splits it into a rotor and a link.
"""

from dataclasses import dataclass
from typing import Literal

import mujoco
import numpy as np

PerJoint = float | dict[str, float]

# Bristles and contacts are springs as stiff as the physics resolves at 4 to 8 kHz: natural
# frequency [rad/s] and damping ratio against the inertia that they hold. At 500 rad/s a friction
# of 0.1 N·m in a joint of 0.02 kg·m² breaks away after 2e-5 rad.
BRISTLE_FREQUENCY = 500.0
BRISTLE_DAMPING_RATIO = 0.7
CONTACT_FREQUENCY = 1000.0
CONTACT_DAMPING_RATIO = 0.1


def per_joint(
    value: PerJoint, joints: tuple[str, ...], absent: float | np.ndarray = 0.0
) -> np.ndarray:
    """One number per joint; `absent`, one or one per joint, where a mapping names none."""
    if not isinstance(value, dict):
        return np.full(len(joints), float(value))
    unknown = set(value) - set(joints)
    if unknown:
        raise ValueError(f"no joint {sorted(unknown)}; there are {joints}")
    others = np.broadcast_to(absent, len(joints))
    return np.array([float(value.get(j, other)) for j, other in zip(joints, others, strict=True)])


@dataclass(frozen=True)
class Plant:
    """What an effect may know of the machine that it acts on.

    Args:
        joints: names, in the order of all arrays.
        timestep_s: physics step.
        inertia: felt by a torque on each motor at the start pose, all else free [kg·m²].
        link_inertia: felt by a torque on each link [kg·m²]; equals `inertia` in rigid joints.
    """

    joints: tuple[str, ...]
    timestep_s: float
    inertia: np.ndarray
    link_inertia: np.ndarray


@dataclass(frozen=True)
class State:
    """The machine in the middle of a physics step, (joints,) each.

    Positions are predicted half a step ahead, q + v h / 2: a spring evaluated there and held for
    the step h conserves energy, where one evaluated at the step's start would feed the motion.

    Args:
        t: time of the session [s]; stands still before a recording starts.
        q: motor position [rad].
        v: motor velocity [rad/s].
        q_link: link position [rad]; equals `q` in rigid joints.
        v_link: link velocity [rad/s].
        motor_torque: what the motors produce, gravity compensation included [N·m].
    """

    t: float
    q: np.ndarray
    v: np.ndarray
    q_link: np.ndarray
    v_link: np.ndarray
    motor_torque: np.ndarray


class HiddenEffect:
    """An effect that the nominal model lacks; the hooks do nothing unless overridden."""

    delay_s = 0.0
    early_s = 0.0  # by which samples are stamped before they are taken
    session_clock = False  # whether the log's clock must be the session's

    def change_model(self, spec: mujoco.MjSpec, joints: tuple[str, ...]) -> None:
        """Change the machine itself, before it is compiled."""

    def start(self, plant: Plant) -> None:
        """Forget all states: a recording begins."""
        self.plant = plant

    def control_rate_hz(self, rate_hz: float) -> float:
        """Rate of the real controller, given the one that the log tells."""
        return rate_hz

    def gains(self, kp: np.ndarray, kd: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Gains of the real controller, given those that the log tells."""
        return kp, kd

    def encoder(self, q: np.ndarray) -> np.ndarray:
        """What controller and log see of a position [rad]."""
        return q

    def motor(self, torque: np.ndarray) -> np.ndarray:
        """Torque that the motors produce, given the one demanded [N·m]; once per physics step."""
        return torque

    def motor_in_motion(self, torque: np.ndarray, v: np.ndarray, t: float) -> np.ndarray:
        """Likewise, of a motor that knows its velocity [rad/s] and the session's time [s]."""
        return torque

    def control(self, error: np.ndarray, period_s: float) -> np.ndarray | float:
        """What the controller adds for a position error [rad], once at each of its ticks [N·m]."""
        return 0.0

    def seen_velocity(self, v: np.ndarray, period_s: float) -> np.ndarray:
        """The velocity that the controller damps by, given the real one [rad/s]; likewise."""
        return v

    def columns(self, t: np.ndarray) -> dict[str, np.ndarray]:
        """What the log tells beside the motion, (K,) each at times (K,) [s] of the session."""
        return {}

    def torque(self, state: State) -> np.ndarray:
        """Additional torque on the motor's side of the joints [N·m]; once per physics step."""
        raise NotImplementedError

    def transmitted(self, state: State) -> np.ndarray:
        """Torque from rotor to link in split joints, 0 in others [N·m]."""
        raise NotImplementedError


# ------------------------------------------------------------------------------------ inertia


@dataclass
class Armature(HiddenEffect):
    """Rotor inertia that the model lacks, reflected through the gear: added [kg·m²]."""

    inertia: PerJoint

    def change_model(self, spec, joints):
        for joint, inertia in zip(joints, per_joint(self.inertia, joints), strict=True):
            spec.joint(joint).armature += inertia


@dataclass
class Payload(HiddenEffect):
    """A ball fixed to the flange, unknown to gravity compensation.

    Args:
        mass: [kg].
        com: centre of mass in the frame of `site` [m].
        radius: of the homogeneous ball that gives it its inertia [m].
        site: the flange.
    """

    mass: float
    com: tuple[float, float, float] = (0.0, 0.0, 0.0)
    radius: float = 0.03
    site: str = "attachment_site"

    def change_model(self, spec, joints):
        site = spec.site(self.site)
        centre = np.empty(3)
        mujoco.mju_rotVecQuat(centre, np.array(self.com, dtype=float), site.quat)
        inertia = 0.4 * self.mass * self.radius**2
        site.parent.add_body(
            name="payload",
            pos=site.pos + centre,
            ipos=np.zeros(3),
            mass=self.mass,
            inertia=[inertia] * 3,
            explicitinertial=True,
        )


# ----------------------------------------------------------------------------------- friction


class Bristles:
    """Elastic-plastic bristles (Prandtl's element): friction that truly sticks.

    τ = −σ0 z with ż = v while |σ0 z| is below the friction level, and |σ0 z| at the level in
    sliding. Rate-independent, no creep. Sticking is damped, so that a joint that stops does not
    ring.

    Args:
        plant: the machine; bristles are as stiff as its time step resolves.
    """

    def __init__(self, plant: Plant):
        self.stiffness = plant.inertia * BRISTLE_FREQUENCY**2
        self.damping = 2 * BRISTLE_DAMPING_RATIO * BRISTLE_FREQUENCY * plant.inertia
        self.anchor = None

    def torque(self, state: State, level: np.ndarray) -> np.ndarray:
        """Friction torque at a friction level [N·m]."""
        if self.anchor is None:
            self.anchor = state.q.copy()
        reach = level / self.stiffness
        stretch = state.q - self.anchor
        bent = np.minimum(np.maximum(stretch, -reach), reach)
        self.anchor = state.q - bent
        pull = self.stiffness * bent + self.damping * state.v * (bent == stretch)
        return -np.minimum(np.maximum(pull, -level), level)


@dataclass
class CoulombFriction(HiddenEffect):
    """Dry friction of constant level Fc.

    Args:
        level: Fc [N·m].
        smooth_velocity: None for bristles that stick; v0 [rad/s] for −Fc tanh(v / v0), which
            creeps, and is stable while Fc / v0 is below the inertia per physics step.
    """

    level: PerJoint
    smooth_velocity: float | None = None

    def start(self, plant):
        self.fc = per_joint(self.level, plant.joints)
        self.bristles = Bristles(plant)

    def torque(self, state):
        if self.smooth_velocity is None:
            return self.bristles.torque(state, self.fc)
        return -self.fc * np.tanh(state.v / self.smooth_velocity)


@dataclass
class ViscousFriction(HiddenEffect):
    """τ = −b v, with b [N·m·s/rad]."""

    coefficient: PerJoint

    def start(self, plant):
        self.b = per_joint(self.coefficient, plant.joints)

    def torque(self, state):
        return -self.b * state.v


@dataclass
class QuadraticFriction(HiddenEffect):
    """τ = −c |v| v, with c [N·m·s²/rad²]."""

    coefficient: PerJoint

    def start(self, plant):
        self.c = per_joint(self.coefficient, plant.joints)

    def torque(self, state):
        return -self.c * np.abs(state.v) * state.v


@dataclass
class StribeckFriction(HiddenEffect):
    """LuGre friction: bristles z of stiffness σ0 and damping σ1, a level that falls with speed.

    ż = v − σ0 |v| z / g(v),  g(v) = Fc + (Fs − Fc) exp(−(v / vs)²),  τ = −(σ0 z + σ1 ż).
    z is advanced by the exact solution over each step's motion.

    Args:
        coulomb: Fc, the level at speed [N·m].
        static: Fs > Fc, the level at rest [N·m].
        velocity: vs, where the level has mostly fallen [rad/s].
        stiffness: σ0 [N·m/rad]; None for what the physics resolves.
        damping: σ1 [N·m·s/rad]; None for a well-damped joint at rest.
    """

    coulomb: PerJoint
    static: PerJoint
    velocity: float
    stiffness: PerJoint | None = None
    damping: PerJoint | None = None

    def start(self, plant):
        self.timestep_s = plant.timestep_s
        self.fc = per_joint(self.coulomb, plant.joints)
        self.fs = per_joint(self.static, plant.joints)
        resolved = Bristles(plant)
        self.sigma0, self.sigma1 = (
            resolved_value if given is None else per_joint(given, plant.joints, resolved_value)
            for given, resolved_value in (
                (self.stiffness, resolved.stiffness),
                (self.damping, resolved.damping),
            )
        )
        self.z = np.zeros(len(plant.joints))
        self.q = None

    def torque(self, state):
        moved = 0.0 if self.q is None else state.q - self.q
        self.q = state.q.copy()
        level = self.fc + (self.fs - self.fc) * np.exp(-((state.v / self.velocity) ** 2))
        level = np.maximum(level, 1e-12)
        sliding = level * np.sign(moved) / self.sigma0
        z = sliding + (self.z - sliding) * np.exp(-self.sigma0 * np.abs(moved) / level)
        rate = (z - self.z) / self.timestep_s
        self.z = z
        return -(self.sigma0 * z + self.sigma1 * rate)


@dataclass
class LoadDependentFriction(HiddenEffect):
    """Dry friction of a loaded gear: |τ_f| ≤ Fc + K |τ_motor|, which sticks.

    After the model M3 of Duclusaud et al., "Extended friction models for the physics simulation
    of servo actuators" (2024), Fc + K_l |τ_m − τ_e|, with the transmitted torque taken as the
    motor's; near balance τ_e ≈ −τ_m, so K ≈ 2 K_l.

    Args:
        load_factor: K [1].
        coulomb: Fc, the level of an unloaded gear [N·m].
    """

    load_factor: PerJoint
    coulomb: PerJoint = 0.0

    def start(self, plant):
        self.factor = per_joint(self.load_factor, plant.joints)
        self.unloaded = per_joint(self.coulomb, plant.joints)
        self.bristles = Bristles(plant)

    def torque(self, state):
        level = self.unloaded + self.factor * np.abs(state.motor_torque)
        return self.bristles.torque(state, level)


# ---------------------------------------------------------------------- torques of the position


@dataclass
class TorqueOffset(HiddenEffect):
    """A constant torque [N·m]: a spring, a cable, a torque sensor's bias."""

    offset: PerJoint

    def start(self, plant):
        self.constant = per_joint(self.offset, plant.joints)

    def torque(self, state):
        return self.constant


@dataclass
class Cogging(HiddenEffect):
    """τ = A sin(N q + φ).

    Args:
        amplitude: A [N·m].
        periods: N, periods in one turn of the joint.
        phase: φ [rad].
    """

    amplitude: PerJoint
    periods: float
    phase: float = 0.0

    def start(self, plant):
        self.a = per_joint(self.amplitude, plant.joints)

    def torque(self, state):
        return self.a * np.sin(self.periods * state.q + self.phase)


# -------------------------------------------------------------------- from command to torque


@dataclass
class TorqueConstant(HiddenEffect):
    """The motor produces `factor` times the torque demanded of it, gravity compensation too."""

    factor: PerJoint

    def start(self, plant):
        self.k = per_joint(self.factor, plant.joints, absent=1.0)

    def motor(self, torque):
        return self.k * torque


@dataclass
class CommandDelay(HiddenEffect):
    """Commands reach the controller `delay_s` after the log says so."""

    delay_s: float


@dataclass
class ActuatorBandwidth(HiddenEffect):
    """First-order lag of the motor torque with cut-off `frequency_hz`, solved exactly."""

    frequency_hz: PerJoint

    def start(self, plant):
        decay = 2 * np.pi * per_joint(self.frequency_hz, plant.joints, np.inf) * plant.timestep_s
        self.at_end = -np.expm1(-decay)
        self.on_average = 1 - self.at_end / decay
        self.last = None

    def motor(self, torque):
        last = torque if self.last is None else self.last
        self.last = last + self.at_end * (torque - last)
        return last + self.on_average * (torque - last)


@dataclass
class TorqueSaturation(HiddenEffect):
    """The motor torque stops at ±`limit` [N·m]."""

    limit: PerJoint

    def start(self, plant):
        self.bound = per_joint(self.limit, plant.joints, absent=np.inf)

    def motor(self, torque):
        return np.minimum(np.maximum(torque, -self.bound), self.bound)


@dataclass
class TorqueRateLimit(HiddenEffect):
    """The motor torque changes by at most `rate` [N·m/s]."""

    rate: PerJoint

    def start(self, plant):
        self.step = per_joint(self.rate, plant.joints, absent=np.inf) * plant.timestep_s
        self.last = None

    def motor(self, torque):
        last = torque if self.last is None else self.last
        change = np.minimum(np.maximum(torque - last, -self.step), self.step)
        self.last = last + change
        return self.last - change * np.abs(change) / (2 * self.step)  # on average in the step


@dataclass
class ControllerGains(HiddenEffect):
    """The controller's real gains are these multiples of what the log tells."""

    kp_factor: PerJoint = 1.0
    kd_factor: PerJoint = 1.0

    def start(self, plant):
        self.factors = (
            per_joint(self.kp_factor, plant.joints, absent=1.0),
            per_joint(self.kd_factor, plant.joints, absent=1.0),
        )

    def gains(self, kp, kd):
        return self.factors[0] * kp, self.factors[1] * kd


@dataclass
class LowRateLoop(HiddenEffect):
    """The control loop runs at `rate_hz`, whatever the log tells."""

    rate_hz: float

    def control_rate_hz(self, rate_hz):
        return self.rate_hz


@dataclass
class EncoderOffset(HiddenEffect):
    """Controller and log see q + `offset` [rad]."""

    offset: PerJoint

    def start(self, plant):
        self.constant = per_joint(self.offset, plant.joints)

    def encoder(self, q):
        return q + self.constant


# ------------------------------------------------------------------------------ two-mass joints


def rotor(joint: str) -> str:
    """Name of the rotor's joint in the generator's model."""
    return f"{joint}_rotor"


class TwoMass(HiddenEffect):
    """A joint split into a rotor, which takes the joint's armature and friction, and a link.

    The rotor turns about a fixed axis and exchanges with the link only the torque of
    `transmitted`: gyroscopic coupling is neglected, as in MuJoCo's armature, so that a rigid
    transmission gives the nominal joint back.
    """

    encoder_side: Literal["motor", "link"]

    def split_joints(self, joints: tuple[str, ...]) -> tuple[str, ...]:
        """Joints that this effect splits."""
        raise NotImplementedError

    def change_model(self, spec, joints):
        for joint in self.split_joints(joints):
            link = spec.joint(joint)
            body = spec.worldbody.add_body(
                name=rotor(joint),
                ipos=np.zeros(3),
                mass=1e-9,
                inertia=[1e-12] * 3,
                explicitinertial=True,
            )
            body.add_joint(
                name=rotor(joint),
                type=link.type,
                axis=(0, 0, 1),
                armature=link.armature,
                damping=link.damping,
                frictionloss=link.frictionloss,
                solref_friction=link.solref_friction,
                solimp_friction=link.solimp_friction,
            )
            link.armature, link.frictionloss = 0.0, 0.0
            link.damping = np.zeros_like(link.damping)


@dataclass
class JointFlexibility(TwoMass):
    """A spring and damper between rotor and link: τ = k (q_m − q_l) + d (v_m − v_l).

    Args:
        stiffness: k [N·m/rad].
        damping: d [N·m·s/rad].
        encoder_side: what controller and log see.
    """

    stiffness: PerJoint
    damping: PerJoint
    encoder_side: Literal["motor", "link"] = "motor"

    def split_joints(self, joints):
        return tuple(np.array(joints)[per_joint(self.stiffness, joints) > 0])

    def start(self, plant):
        self.k = per_joint(self.stiffness, plant.joints)
        self.d = per_joint(self.damping, plant.joints) * (self.k > 0)

    def transmitted(self, state):
        return self.k * (state.q - state.q_link) + self.d * (state.v - state.v_link)


@dataclass
class Backlash(TwoMass):
    """A gap between rotor and link; a stiff, lightly damped contact that never pulls closes it.

    Args:
        width: free play, from one tooth flank to the other [rad].
        encoder_side: what controller and log see.
    """

    width: PerJoint
    encoder_side: Literal["motor", "link"] = "motor"

    def split_joints(self, joints):
        return tuple(np.array(joints)[per_joint(self.width, joints) > 0])

    def start(self, plant):
        self.half = per_joint(self.width, plant.joints) / 2
        reduced = 1 / (1 / plant.inertia + 1 / plant.link_inertia) * (self.half > 0)
        self.k = reduced * CONTACT_FREQUENCY**2
        self.d = 2 * CONTACT_DAMPING_RATIO * CONTACT_FREQUENCY * reduced

    def transmitted(self, state):
        play = state.q - state.q_link
        depth = play - np.minimum(np.maximum(play, -self.half), self.half)
        side = np.sign(depth)
        push = self.k * np.abs(depth) + self.d * side * (state.v - state.v_link)
        return side * np.maximum(push, 0.0)


# ---------------------------------------------------- effects that a diagnosis tool may not know


@dataclass
class DriftingFriction(HiddenEffect):
    """Dry friction whose level drifts in a session: F(t) = F0 + (F1 − F0) (1 − exp(−t / T)).

    Args:
        start_level: F0 [N·m].
        end_level: F1 [N·m].
        time_constant_s: T.
    """

    start_level: PerJoint
    end_level: PerJoint
    time_constant_s: float

    def start(self, plant):
        self.first = per_joint(self.start_level, plant.joints)
        self.last = per_joint(self.end_level, plant.joints)
        self.bristles = Bristles(plant)

    def torque(self, state):
        warmth = -np.expm1(-state.t / self.time_constant_s)
        return self.bristles.torque(state, self.first + (self.last - self.first) * warmth)


@dataclass
class OddPositionTorque(HiddenEffect):
    """A bump on a cubic: τ = A (exp(−((q − q0) / w)²) − ((q − qc) / r)³).

    Args:
        amplitude: A [N·m].
        bump: q0 [rad].
        width: w [rad].
        centre: qc [rad].
        reach: r [rad].
    """

    amplitude: PerJoint
    bump: PerJoint = 0.1
    width: float = 0.08
    centre: PerJoint = 0.0
    reach: float = 0.5

    def start(self, plant):
        self.a = per_joint(self.amplitude, plant.joints)
        self.q0 = per_joint(self.bump, plant.joints)
        self.qc = per_joint(self.centre, plant.joints)

    def torque(self, state):
        bump = np.exp(-(((state.q - self.q0) / self.width) ** 2))
        return self.a * (bump - ((state.q - self.qc) / self.reach) ** 3)


@dataclass
class TimeVaryingTorque(HiddenEffect):
    """τ = A sin(2π f t + φ) in the session's time t, unrelated to the commands.

    Args:
        amplitude: A [N·m].
        frequency_hz: f.
        phase: φ [rad].
    """

    amplitude: PerJoint
    frequency_hz: float
    phase: float = 0.0

    def start(self, plant):
        self.a = per_joint(self.amplitude, plant.joints)

    def torque(self, state):
        return self.a * np.sin(2 * np.pi * self.frequency_hz * state.t + self.phase)


@dataclass
class HysteresisTorque(HiddenEffect):
    """Rate-independent hysteresis of a cable or seal, a saturating spring that remembers.

    Prandtl and Ishlinskii's sum of elastic-plastic elements that yield one after the other at
    deflections of w/4, w/2 and w: τ = −(F/3) Σ z_i / w_i, ż_i = v within |z_i| ≤ w_i.

    Args:
        amplitude: F, the torque once all have yielded [N·m].
        width: w [rad].
    """

    amplitude: PerJoint
    width: float

    def start(self, plant):
        self.a = per_joint(self.amplitude, plant.joints)
        self.yields = self.width * np.array([[0.25], [0.5], [1.0]])
        self.anchors = None

    def torque(self, state):
        if self.anchors is None:
            self.anchors = np.tile(state.q, (3, 1))
        z = np.clip(state.q - self.anchors, -self.yields, self.yields)
        self.anchors = state.q - z
        return -self.a * np.mean(z / self.yields, axis=0)
