"""Further effects that real robots have: springs, tilt, link masses, loops, bristles, warming.

As in `effects`, each is a small class with one explicit equation. t is the session's time.
"""

from dataclasses import dataclass

import mujoco
import numpy as np

from benchmarks.hidden_effects.effects import (
    Bristles,
    DriftingFriction,
    HiddenEffect,
    PerJoint,
    StribeckFriction,
    TimeVaryingTorque,
    per_joint,
)

RATED_V = 12.0


@dataclass
class ParallelSpring(HiddenEffect):
    """τ = −k (q − q0): k [N·m/rad], q0 [rad]."""

    stiffness: PerJoint
    rest: PerJoint

    def start(self, plant):
        self.k = per_joint(self.stiffness, plant.joints)
        self.q0 = per_joint(self.rest, plant.joints)

    def torque(self, state):
        return -self.k * (state.q - self.q0)


@dataclass
class BaseTilt(HiddenEffect):
    """The base is turned by Rx(roll) Ry(pitch) [rad]: gravity turns the other way."""

    roll: float
    pitch: float

    def change_model(self, spec, joints):
        about_x, about_y = np.empty(4), np.empty(4)
        mujoco.mju_axisAngle2Quat(about_x, np.array([1.0, 0, 0]), self.roll)
        mujoco.mju_axisAngle2Quat(about_y, np.array([0, 1.0, 0]), self.pitch)
        base, back, gravity = np.empty(4), np.empty(4), np.empty(3)
        mujoco.mju_mulQuat(base, about_x, about_y)
        mujoco.mju_negQuat(back, base)
        mujoco.mju_rotVecQuat(gravity, np.array(spec.option.gravity, float), back)
        spec.option.gravity = gravity


@dataclass
class LinkInertia(HiddenEffect):
    """A link of mass a m, its centre shifted by δ [m], and of a b times the inertia about it."""

    link: str
    mass_factor: float = 1.0
    shift: tuple[float, float, float] = (0.0, 0.0, 0.0)
    inertia_factor: float = 1.0

    def change_model(self, spec, joints):
        nominal = spec.copy().compile()
        was, link = nominal.body(self.link), spec.body(self.link)
        link.mass = self.mass_factor * was.mass[0]
        link.ipos = was.ipos + np.array(self.shift)
        link.iquat = was.iquat
        link.inertia = self.mass_factor * self.inertia_factor * was.inertia
        link.explicitinertial = True


@dataclass
class IntegralAction(HiddenEffect):
    """The controller adds I ← clip(I + Ki h e, ±limit) at each tick: Ki [N·m/(rad·s)], [N·m]."""

    gain: PerJoint
    limit: PerJoint

    def start(self, plant):
        self.ki = per_joint(self.gain, plant.joints)
        self.bound = per_joint(self.limit, plant.joints, np.inf)
        self.sum = np.zeros(len(plant.joints))

    def control(self, error, period_s):
        self.sum = np.clip(self.sum + self.ki * period_s * error, -self.bound, self.bound)
        return self.sum


@dataclass
class VelocityFilter(HiddenEffect):
    """The controller's velocity is x ← x + (1 − exp(−2π f h)) (v − x) at each tick, f [Hz]."""

    frequency_hz: float

    def start(self, plant):
        self.x = np.zeros(len(plant.joints))

    def seen_velocity(self, v, period_s):
        self.x = self.x - np.expm1(-2 * np.pi * self.frequency_hz * period_s) * (v - self.x)
        return self.x


@dataclass
class JointCoupling(HiddenEffect):
    """A cable along two joints: V = k (q_i + r q_j − c)²/2, Rayleigh's d (v_i + r v_j)²/2.

    Args:
        joint, other: i and j, names.
        stiffness, damping: k [N·m/rad], d [N·m·s/rad].
        ratio: r.
        rest: c [rad].
    """

    joint: str
    other: str
    stiffness: float
    ratio: float = 1.0
    rest: float = 0.0
    damping: float = 0.0

    def start(self, plant):
        names = list(plant.joints)
        self.lever = np.zeros(len(names))
        self.lever[names.index(self.joint)] = 1.0
        self.lever[names.index(self.other)] = self.ratio

    def torque(self, state):
        stretch = self.lever @ state.q - self.rest
        return -self.lever * (self.stiffness * stretch + self.damping * (self.lever @ state.v))


@dataclass
class DahlFriction(HiddenEffect):
    """dF/dq = σ0 (1 − F sign(v) / Fc), τ = −F, over each step's motion exactly.

    Args:
        coulomb: Fc [N·m].
        presliding: Fc / σ0 [rad].
    """

    coulomb: PerJoint
    presliding: float

    def start(self, plant):
        self.fc = np.maximum(per_joint(self.coulomb, plant.joints), 1e-12)
        self.f, self.q = np.zeros(len(plant.joints)), None

    def torque(self, state):
        moved = 0.0 if self.q is None else state.q - self.q
        self.q = state.q.copy()
        end = self.fc * np.sign(moved)
        self.f = end + (self.f - end) * np.exp(-np.abs(moved) / self.presliding)
        return -self.f


@dataclass
class LugreFriction(StribeckFriction):
    """LuGre friction whose bristles are soft enough to be seen: give `stiffness` and `damping`."""


@dataclass
class DirectionalFriction(HiddenEffect):
    """Bristles that slip at F₊ in positive and at F₋ in negative motion [N·m]."""

    forward: PerJoint
    backward: PerJoint

    def start(self, plant):
        self.levels = (
            per_joint(self.forward, plant.joints),
            per_joint(self.backward, plant.joints),
        )
        bristles = Bristles(plant)
        self.k, self.d, self.anchor = bristles.stiffness, bristles.damping, None

    def torque(self, state):
        if self.anchor is None:
            self.anchor = state.q.copy()
        forward, backward = self.levels
        stretch = state.q - self.anchor
        bent = np.clip(stretch, -backward / self.k, forward / self.k)
        self.anchor = state.q - bent
        pull = self.k * bent + self.d * state.v * (bent == stretch)
        return -np.clip(pull, -backward, forward)


@dataclass
class TorqueSpeedLimit(HiddenEffect):
    """|τ + τs v / ω0| ≤ τs U / 12 V, U the supply voltage, which sags while the session lasts.

    Args:
        stall_torque: τs at 12 V [N·m].
        no_load_speed: ω0 at 12 V [rad/s].
        volts: U when the session begins [V].
        sag_v_per_s: by which it falls [V/s]; logged where it is not zero.
    """

    stall_torque: PerJoint
    no_load_speed: PerJoint
    volts: float = RATED_V
    sag_v_per_s: float = 0.0

    def start(self, plant):
        self.most = per_joint(self.stall_torque, plant.joints, np.inf)
        fastest = per_joint(self.no_load_speed, plant.joints, 1.0)
        self.slope = np.where(np.isfinite(self.most), self.most, 0.0) / fastest

    def supply(self, t):
        return self.volts - self.sag_v_per_s * t

    def motor_in_motion(self, torque, v, t):
        most = self.most * self.supply(t) / RATED_V
        return np.clip(torque, -most - self.slope * v, most - self.slope * v)

    def columns(self, t):
        return {"supply_voltage": self.supply(t)} if self.sag_v_per_s else {}


@dataclass
class PeriodicTorque(TimeVaryingTorque):
    """A swinging torque where the log's clock is the session's, so that its phase is told."""

    session_clock = True


@dataclass
class FrictionDrift(DriftingFriction):
    """Friction that drifts where the log's clock is the session's."""

    session_clock = True


@dataclass
class TorqueConstantDrift(HiddenEffect):
    """The motor delivers k(t) = k1 + (k0 − k1) exp(−t / T) of its torque; T [s]."""

    at_start: float
    at_end: float
    time_constant_s: float
    session_clock = True

    def motor_in_motion(self, torque, v, t):
        left = np.exp(-t / self.time_constant_s)
        return torque * (self.at_end + (self.at_start - self.at_end) * left)


@dataclass
class Warming(HiddenEffect):
    """θ(t) = first + rise (1 − exp(−t / T)), logged [°C, K, s]."""

    first_c: float = 22.0
    rise_k: float = 40.0
    time_constant_s: float = 15.0

    def temperature(self, t):
        return self.first_c - self.rise_k * np.expm1(-t / self.time_constant_s)

    def columns(self, t):
        return {"temperature": self.temperature(t)}


@dataclass
class FrictionTemperature(Warming):
    """Dry friction of F25 + c (θ − 25) [N·m, N·m/K]."""

    level: float = 0.0
    per_kelvin: float = 0.0

    def start(self, plant):
        self.bristles = Bristles(plant)

    def torque(self, state):
        warmer = self.temperature(state.t) - 25.0
        level = max(self.level + self.per_kelvin * warmer, 0.0)
        return self.bristles.torque(state, np.full(len(state.q), level))


@dataclass
class TorqueConstantTemperature(Warming):
    """The motor delivers 1 + α (θ − 25) of its torque [1/K]."""

    per_kelvin: float = 0.0

    def motor_in_motion(self, torque, v, t):
        return torque * (1 + self.per_kelvin * (self.temperature(t) - 25.0))


@dataclass
class ClockOffset(HiddenEffect):
    """A sample stamped t was taken at t + `early_s`."""

    early_s: float


@dataclass
class TorqueSinceStart(HiddenEffect):
    """τ = A sin(2π f t), t since the recording's start: A [N·m], f [Hz]."""

    amplitude: PerJoint
    frequency_hz: float

    def start(self, plant):
        self.a, self.begin = per_joint(self.amplitude, plant.joints), None

    def torque(self, state):
        self.begin = state.t if self.begin is None else self.begin
        return self.a * np.sin(2 * np.pi * self.frequency_hz * (state.t - self.begin))


@dataclass
class UnevenFriction(HiddenEffect):
    """Dry friction of a bent shaft or a worn gear: |τ| ≤ F (1 + s sin(N q + φ)), which sticks.

    Args:
        level: F [N·m].
        share: s, below one.
        periods: N, periods in one turn of the joint.
        phase: φ [rad].
    """

    level: PerJoint
    share: float
    periods: float
    phase: float

    def start(self, plant):
        self.f = per_joint(self.level, plant.joints)
        self.bristles = Bristles(plant)

    def torque(self, state):
        wave = np.sin(self.periods * state.q + self.phase)
        return self.bristles.torque(state, self.f * (1 + self.share * wave))
