"""A test set over more robots: sizes, loops, gains, logs and several effects, drawn from a seed.

Sizes are multiples of a joint's own torque, speed and inertia along a motion like those recorded,
evenly in the logarithm between barely visible, `VISIBLE` times the encoder's noise, and
dominating, `DOMINATING` of the joint's own torque. No loop is drawn that does not settle.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np

from benchmarks.hidden_effects import effects as fx
from benchmarks.hidden_effects import real_effects as rx
from benchmarks.hidden_effects.cases import ROBOTS, VISIBLE, Case, scaled
from benchmarks.hidden_effects.commands import COMMANDS, multisine
from benchmarks.hidden_effects.drawn_cases import Draw, log_traits
from benchmarks.hidden_effects.generator import read

NAMES = ("ur5e", "quadruped_leg", "scara", "hobby_arm", "heavy_arm", "light_arm")
LOOPS_HZ = {"hobby_arm": (200,), "heavy_arm": (100,)}
ANY_LOOP_HZ = (100, 200, 250, 500, 1000)
COMMANDS_HZ = (25, 50, 100)  # of those that the loop's rate is a multiple of
SAMPLES_HZ = (100, 200, 250)
PHYSICS_HZ = 4000
COUNT_HOBBY = 2 * np.pi / 4096  # rad; of an encoder of 12 bits, 0.088°

SCALE = (10**-1.5, 10**1.5)  # of all masses: three decades
DOMINATING = 0.7  # share of a joint's own torque
GAIN_MARGIN = 3.0  # all gains can grow by this factor before a loop runs away
SAG_RAD = 0.3  # no joint hangs further below its command by its own weight
MOST_EFFECTS = 5
PER_ROBOT = 7  # cases of known effects


@dataclass(frozen=True)
class Loop:
    """A robot along a typical motion, and the loop around it; (joints,) each.

    Args:
        joints, links: names.
        home: where it moves about [rad].
        mass: of the joints at home, (joints, joints) [kg·m²].
        armature: rotor inertia [kg·m²].
        reach, speed, acceleration: RMS of the motion [rad, rad/s, rad/s²].
        torque, peak, weight: RMS and peak of the torque, peak of gravity's part [N·m].
        total: mass of all links [kg].
        length: between a joint and the flange at most [m].
        slides: which joints are slides.
    """

    joints: tuple[str, ...]
    links: tuple[str, ...]
    home: np.ndarray
    mass: np.ndarray
    armature: np.ndarray
    reach: np.ndarray
    speed: np.ndarray
    acceleration: np.ndarray
    torque: np.ndarray
    peak: np.ndarray
    weight: np.ndarray
    total: float
    length: float
    slides: np.ndarray

    @staticmethod
    def of(mjcf, joints: Sequence[str], home, amplitude) -> "Loop":
        """Inverse dynamics along a multisine."""
        model = read(mjcf).compile()
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
        data, rate = mujoco.MjData(model), 100.0
        t = np.arange(0, 5, 1 / rate)
        q = np.array(home) + multisine(np.random.default_rng(0), np.array(amplitude), 5.0)(t)
        v = np.gradient(q, 1 / rate, axis=0)
        a = np.gradient(v, 1 / rate, axis=0)
        torque, weight = np.empty_like(q), np.empty_like(q)
        for i in range(len(t)):
            data.qpos[:], data.qvel[:], data.qacc[:] = q[i], 0, 0
            mujoco.mj_inverse(model, data)
            weight[i] = data.qfrc_inverse
            data.qvel[:], data.qacc[:] = v[i], a[i]
            mujoco.mj_inverse(model, data)
            torque[i] = data.qfrc_inverse
        data.qpos[:] = home
        mujoco.mj_forward(model, data)
        mass = np.empty((model.nv, model.nv))
        mujoco.mj_fullM(model, data, mass)
        site = data.site("attachment_site").xpos
        return Loop(
            tuple(joints),
            tuple(model.body(i).name for i in range(1, model.nbody)),
            np.array(home),
            mass,
            model.dof_armature.copy(),
            *(np.sqrt(np.mean(x**2, axis=0)) for x in (q - home, v, a, torque)),
            np.abs(torque).max(axis=0),
            np.abs(weight).max(axis=0),
            float(model.body_mass.sum()),
            float(np.linalg.norm(data.xanchor - site, axis=1).max()),
            model.jnt_type == mujoco.mjtJoint.mjJNT_SLIDE,
        )


def settles(mass: np.ndarray, kp: np.ndarray, kd: np.ndarray, period_s: float) -> bool:
    """Whether M q̈ = −Kp q − Kd q̇, held over each period, comes to rest."""
    n = len(mass)
    force = -np.hstack([np.diag(kp), np.diag(kd)])
    answer = np.linalg.solve(mass, force)
    step = np.block([[np.eye(n), period_s * np.eye(n)], [np.zeros((n, n)), np.eye(n)]])
    step += np.vstack([0.5 * period_s**2 * answer, period_s * answer])
    return bool(np.abs(np.linalg.eigvals(step)).max() < 1)


class RobotDraw(Draw):
    """Draws for one case on one robot.

    Args:
        rng: of all draws.
        robot: key of `ROBOTS`.
        loop: the robot with its masses scaled.
        changes: fields of its `Setup`.
    """

    def __init__(self, rng: np.random.Generator, robot: str, loop: Loop, changes: dict):
        super().__init__(rng, robot)
        self.loop, self.changes = loop, changes
        self.kp = np.array([kp for kp, _ in changes["gains"]])
        self.kd = np.array([kd for _, kd in changes["gains"]])
        noise, step = changes["encoder_noise_rad"], changes["encoder_resolution_rad"]
        self.noise_rad = float(np.hypot(noise, step / 12**0.5))

    @cached_property
    def faintest(self) -> np.ndarray:
        """(joints,) torque that moves a joint by `VISIBLE` times the noise [N·m]."""
        return VISIBLE * self.noise_rad * np.exp(np.log(self.kp).mean(axis=0))

    @cached_property
    def crossover_hz(self) -> float:
        """Of the fastest joint under the stiffest gains."""
        fastest = np.linalg.eigvals(np.linalg.solve(self.loop.mass, np.diag(self.kd.max(axis=0))))
        natural = np.sqrt(self.kp.max(axis=0) / np.diag(self.loop.mass))
        return float(max(np.abs(fastest).max(), natural.max()) / (2 * np.pi))

    def torque(self, joint: int) -> float:
        """A torque between barely visible and dominating [N·m]."""
        low, most = self.faintest[joint], DOMINATING * self.loop.torque[joint]
        return self.size(low, max(most, 3 * low))

    def share(self, joint: int, most: float) -> float:
        """A share of the joint's own torque, likewise, up to `most` of it."""
        return self.size(min(self.faintest[joint] / self.loop.torque[joint], most / 3), most)

    def some(self, allowed: np.ndarray | None = None) -> list[int]:
        """Some joints, at least one, of those allowed."""
        among = np.flatnonzero(np.ones(len(self.loop.joints)) if allowed is None else allowed)
        count = self.rng.integers(1, len(among) + 1)
        return sorted(self.rng.choice(among, count, replace=False).tolist())

    def on(self, joints: Sequence[int], value: Callable[[int], float]) -> dict[str, float]:
        """A value for each joint, to three digits."""
        return {self.loop.joints[j]: float(f"{value(j):.3g}") for j in joints}

    def torques(self, per: np.ndarray | float = 1.0, signed: bool = False) -> dict[str, float]:
        """Torques over `per` for some joints."""
        per = np.broadcast_to(per, len(self.loop.joints))
        return self.on(
            self.some(),
            lambda j: self.torque(j) / per[j] * (self.rng.choice([-1, 1]) if signed else 1),
        )

    def one(self, allowed: np.ndarray | None = None) -> int:
        """One joint."""
        return int(self.rng.choice(self.some(allowed)))

    def seconds(self) -> float:
        """A time by which the fastest joint's motion shows, a whole number of physics steps [s]."""
        fastest = self.loop.speed.max()
        low = min(VISIBLE * self.noise_rad / fastest, 0.01)
        steps = round(self.size(max(low, 1 / PHYSICS_HZ), 0.03) * PHYSICS_HZ)
        return max(steps, 1) / PHYSICS_HZ

    def cutoff_hz(self) -> float:
        """Of a filter in the loop, from what shows little to what nearly upsets it [Hz]."""
        return self.size(2.5 * self.crossover_hz, 15 * self.crossover_hz)

    def shift(self) -> tuple[float, float, float]:
        """Of a centre of mass [m]."""
        most = 0.1 * self.loop.length
        return tuple(self.signed(0.1 * most, most) for _ in range(3))

    def near_home(self, joints: Sequence[str]) -> dict[str, float]:
        """A place for each joint within twice its motion [rad]."""
        chosen = [self.loop.joints.index(name) for name in joints]
        return self.on(
            chosen, lambda j: self.loop.home[j] + 2 * self.between(-1, 1) * self.loop.reach[j]
        )

    def slower_loops(self) -> list[float]:
        """Rates below the one told at which the loop settles under all gains [Hz]."""
        told = self.changes["control_rate_hz"]
        rates = [told / by for by in (2, 4, 5, 8, 10) if (PHYSICS_HZ * by / told).is_integer()]
        return [rate for rate in rates if self.settles_at(rate, 1.5)]

    def settles_at(self, rate_hz: float, margin: float) -> bool:
        """Whether the loop settles under all gains, each `margin` times as high."""
        return all(
            settles(self.loop.mass, margin * kp, margin * kd, 1 / rate_hz)
            for kp, kd in zip(self.kp, self.kd, strict=True)
        )

    def possible(self, kind: str) -> bool:
        """Whether this robot and its loop can have an effect, and would show it."""
        if kind == "low_rate_loop":
            return bool(self.slower_loops())
        if kind == "joint_flexibility":
            return bool(_flexible(self).any())
        if kind == "backlash":
            return bool((_flexible(self) & ~self.loop.slides).any())
        if kind == "encoder_offset":
            return self.changes["gravity_compensation"] is False
        return True

    def known(self, count: int) -> tuple[fx.HiddenEffect, ...]:
        """Effects that the library knows, each of another group."""
        hidden, groups = [], set()
        for kind in self.rng.permutation(list(KINDS)).tolist():
            group, make = KINDS[kind]
            if len(hidden) < count and group not in groups and self.possible(kind):
                hidden.append(make(self))
                groups.add(group)
        return tuple(hidden)


def _about_one(d: RobotDraw, joint: int, most: float) -> float:
    return 1 + float(d.rng.choice([-1, 1])) * d.share(joint, most)


def _stribeck(d: RobotDraw):
    j = d.one()
    static = d.torque(j)
    return fx.StribeckFriction(
        d.on([j], lambda _: static / d.size(1.5, 4)),
        d.on([j], lambda _: static),
        float(f"{d.loop.speed[j] * d.size(0.05, 0.5):.3g}"),
    )


def _lugre(d: RobotDraw):
    j = d.one()
    static, inertia = d.torque(j), d.loop.mass[j, j]
    # no stiffer than the physics resolves
    stiffness = min(static / (d.loop.reach[j] * d.size(5e-3, 5e-2)), inertia * 300.0**2)
    return rx.LugreFriction(
        d.on([j], lambda _: static / d.size(1.2, 3)),
        d.on([j], lambda _: static),
        float(f"{d.loop.speed[j] * d.size(0.05, 0.5):.3g}"),
        d.on([j], lambda _: stiffness),
        d.on([j], lambda _: d.size(0.2, 1.0) * np.sqrt(stiffness * inertia)),
    )


def _directional(d: RobotDraw):
    joints = d.some()
    levels = [d.on(joints, lambda j: d.torque(j)) for _ in range(2)]
    return rx.DirectionalFriction(*levels)


def _dahl(d: RobotDraw):
    j = d.one()
    presliding = float(f"{d.loop.reach[j] * d.size(5e-3, 0.1):.3g}")
    return rx.DahlFriction(d.on([j], d.torque), presliding)


def _drift(d: RobotDraw):
    joints, more = d.some(), d.size(1.5, 5)
    levels = [d.on(joints, d.torque)]
    levels.append({name: float(f"{level / more:.3g}") for name, level in levels[0].items()})
    order = levels if d.rng.random() < 0.7 else levels[::-1]
    return rx.FrictionDrift(*order, d.size(5, 25))


def _spring(d: RobotDraw):
    stiffness = d.torques(per=d.loop.reach)
    return rx.ParallelSpring(stiffness, d.near_home(stiffness))


def _saturation(d: RobotDraw):
    # an arm that swings beyond its path must still be lifted
    return fx.TorqueSaturation(
        d.on(d.some(), lambda j: max(d.size(0.5, 0.95) * d.loop.peak[j], 2 * d.loop.weight[j]))
    )


def _speed_limit(d: RobotDraw):
    joints = d.some()
    stall = d.on(joints, lambda j: max(d.size(0.8, 2) * d.loop.peak[j], 2 * d.loop.weight[j]))
    return rx.TorqueSpeedLimit(stall, d.on(joints, lambda j: d.size(3, 10) * d.loop.speed[j]))


def _rate_limit(d: RobotDraw):
    # the torque of a step of the motion's size, within a fraction of the loop's time
    jump = 2 * d.kp.max(axis=0) * d.loop.reach
    fast = 2 * np.pi * d.crossover_hz
    return fx.TorqueRateLimit(d.on(d.some(), lambda j: d.size(1.5, 10) * jump[j] * fast))


def _flexible(d: RobotDraw) -> np.ndarray:
    """Joints whose rotor alone settles under the loop, so that the rest can hang on a spring."""
    period, steady = 1 / d.changes["control_rate_hz"], np.zeros(len(d.loop.joints), bool)
    for j in range(len(steady)):
        rotor, gains = d.loop.armature[j : j + 1, None], (d.kp.max(0)[j], d.kd.max(0)[j])
        steady[j] = settles(rotor, *(1.5 * np.array([gain]) for gain in gains), period)
    return steady


def _flexibility(d: RobotDraw):
    joints = d.some(_flexible(d))
    stiffer = d.size(4, 20)
    stiffness = d.on(joints, lambda j: stiffer * d.kp.max(axis=0)[j])
    damping = {
        name: float(f"{0.1 * np.sqrt(k * d.loop.mass[j, j]):.3g}")
        for j, (name, k) in zip(joints, stiffness.items(), strict=True)
    }
    return fx.JointFlexibility(stiffness, damping)


def _backlash(d: RobotDraw):
    low = 5 * d.noise_rad
    joints = d.some(_flexible(d) & ~d.loop.slides)
    return fx.Backlash(d.on(joints, lambda j: d.size(low, max(0.04, 3 * low))))


def _low_rate(d: RobotDraw):
    return fx.LowRateLoop(float(d.rng.choice(d.slower_loops())))


def _integral(d: RobotDraw):
    joints = d.some()
    gain = d.size(0.1, 2)  # per second, of the stiffness
    return rx.IntegralAction(
        d.on(joints, lambda j: gain * d.kp.min(axis=0)[j]), d.on(joints, d.torque)
    )


def _coupling(d: RobotDraw):
    i, j = d.rng.choice(np.flatnonzero(~d.loop.slides), 2, replace=False).tolist()
    ratio = d.signed(0.3, 1.2)
    stiffness = d.torque(i) / d.loop.reach[i]
    stretch = d.loop.home[i] + ratio * d.loop.home[j] + d.between(-0.2, 0.2)
    return rx.JointCoupling(
        d.loop.joints[i], d.loop.joints[j], float(f"{stiffness:.3g}"), ratio,
        float(f"{stretch:.3g}"), float(f"{0.05 * stiffness:.3g}"),
    )  # fmt: skip


# name: (group, maker); a case has one effect of a group at most, for two would tell nothing apart.
KINDS: dict[str, tuple[str, Callable[[RobotDraw], fx.HiddenEffect]]] = {
    "armature": ("inertia", lambda d: fx.Armature(d.torques(d.loop.acceleration))),
    "coulomb_friction": ("dry", lambda d: fx.CoulombFriction(d.torques())),
    "stribeck_friction": ("dry", _stribeck),
    "load_dependent_friction": (
        "dry", lambda d: fx.LoadDependentFriction(d.on(d.some(), lambda j: d.share(j, 0.3)))),
    "directional_friction": ("dry", _directional),
    "dahl_friction": ("dry", _dahl),
    "lugre_friction": ("dry", _lugre),
    "friction_drift": ("dry", _drift),
    "viscous_friction": ("wet", lambda d: fx.ViscousFriction(d.torques(d.loop.speed))),
    "quadratic_friction": ("wet", lambda d: fx.QuadraticFriction(d.torques(d.loop.speed**2))),
    "torque_offset": ("offset", lambda d: fx.TorqueOffset(d.torques(signed=True))),
    "parallel_spring": ("spring", _spring),
    "joint_coupling": ("spring", _coupling),
    "cogging": (
        "cogging",
        lambda d: fx.Cogging(d.torques(), float(d.rng.integers(8, 60)), d.between(-3, 3))),
    "periodic_torque": (
        "time", lambda d: rx.PeriodicTorque(d.torques(), d.size(0.3, 3), d.between(-3, 3))),
    "payload": (
        "load",
        lambda d: fx.Payload(
            float(f"{d.loop.total * d.size(3e-3, 0.1):.3g}"), d.shift(), d.loop.length / 50)),
    "link_inertia": (
        "load",
        lambda d: rx.LinkInertia(
            str(d.rng.choice(d.loop.links)), d.size(0.6, 1.7), d.shift(), d.size(0.7, 1.5))),
    "base_tilt": ("tilt", lambda d: rx.BaseTilt(d.signed(0.01, 0.1), d.signed(0.02, 0.2))),
    "torque_constant": (
        "motor", lambda d: fx.TorqueConstant(d.on(d.some(), lambda j: _about_one(d, j, 0.3)))),
    "controller_gains": (
        "motor",
        lambda d: fx.ControllerGains(
            d.on(joints := d.some(), lambda j: _about_one(d, j, 0.3)),
            d.on(joints, lambda j: _about_one(d, j, 0.3)))),
    "torque_constant_drift": (
        "motor", lambda d: rx.TorqueConstantDrift(1.0, d.between(0.6, 0.95), d.size(8, 25))),
    "torque_constant_temperature": (
        "motor", lambda d: rx.TorqueConstantTemperature(per_kelvin=-d.size(1e-3, 6e-3))),
    "torque_saturation": ("limit", _saturation),
    "torque_speed_limit": ("limit", _speed_limit),
    "command_delay": ("delay", lambda d: fx.CommandDelay(d.seconds())),
    "clock_offset": ("delay", lambda d: rx.ClockOffset(d.seconds())),
    "actuator_bandwidth": ("lag", lambda d: fx.ActuatorBandwidth(d.cutoff_hz())),
    "velocity_filter": ("lag", lambda d: rx.VelocityFilter(d.cutoff_hz())),
    "torque_rate_limit": ("lag", _rate_limit),
    "low_rate_loop": ("lag", _low_rate),
    "integral_action": ("lag", _integral),
    "encoder_offset": (
        "encoder", lambda d: fx.EncoderOffset(d.on(d.some(), lambda j: d.signed(0.005, 0.06)))),
    "joint_flexibility": ("two_mass", _flexibility),
    "backlash": ("two_mass", _backlash),
}  # fmt: skip


def _odd(d: RobotDraw):
    j = d.one()
    reach, home = d.loop.reach[j], d.loop.home[j]
    return fx.OddPositionTorque(
        d.on([j], d.torque),
        d.on([j], lambda _: home + reach * d.between(-1, 1)),
        float(f"{reach * d.size(0.2, 0.6):.3g}"),
        d.on([j], lambda _: home),
        float(f"{2 * reach:.3g}"),
    )


def _hysteresis(d: RobotDraw):
    j = d.one()
    return fx.HysteresisTorque(
        d.on([j], d.torque), float(f"{d.loop.reach[j] * d.size(0.2, 2):.3g}")
    )


def _uneven(d: RobotDraw):
    j = d.one()
    # one to four periods in the range of its motion
    periods = np.pi * d.size(1, 4) / (2 * d.loop.reach[j])
    return rx.UnevenFriction(
        d.on([j], d.torque), d.between(0.5, 0.9), float(f"{periods:.3g}"), d.between(-3, 3)
    )


# What the library has no name for, and what it has one for since; the draws depend on the order.
UNKNOWN: dict[str, Callable[[RobotDraw], fx.HiddenEffect]] = {
    "odd_position_torque": _odd,
    "hysteresis_torque": _hysteresis,
    "time_varying_torque": lambda d: fx.TimeVaryingTorque(
        d.torques(), d.size(0.3, 3), d.between(-3, 3)
    ),
    "uneven_friction": _uneven,
}


def _gains(d: Draw, loop: Loop, rate_hz: float) -> tuple[tuple, ...]:
    """One to three settings (Kp, Kd), compliant to stiff, that settle with a margin.

    Kp = M ω² and Kd = 2 ζ M ω, with the joint's inertia M at home.
    """
    count = int(d.rng.integers(1, 4))
    inertia = np.diag(loop.mass)
    apart = d.size(1.3, 2)  # of their natural frequencies
    omega = d.size(12, 40) * np.exp(d.rng.uniform(-0.2, 0.2, len(inertia)))
    zeta = d.size(0.4, 1.2)
    fastest = GAIN_MARGIN * inertia * omega**2, GAIN_MARGIN * 2 * zeta * inertia * omega
    while not settles(loop.mass, *fastest, 1 / rate_hz):
        omega = 0.8 * omega
        fastest = GAIN_MARGIN * inertia * omega**2, GAIN_MARGIN * 2 * zeta * inertia * omega
    settings = []
    for i in range(count):
        slower = omega / apart ** (count - 1 - i)
        pair = inertia * slower**2, 2 * zeta * inertia * slower
        settings.append(tuple(tuple(float(f"{x:.3g}") for x in gain) for gain in pair))
    return tuple(settings)


def _setup(d: Draw, loop: Loop) -> dict:
    """Fields of `Setup`: gains, rates, noise, gravity, log."""
    control = int(d.rng.choice(LOOPS_HZ.get(d.robot, ANY_LOOP_HZ)))
    gains = _gains(d, loop, control)
    softest = np.array(gains[0][0])
    choices = [True, "continuous"]
    if np.all(loop.weight <= SAG_RAD * softest):
        choices += [False, False]
    noise = d.size(1e-5, 3e-4)
    step = noise * d.size(0.1, 3)
    command = int(d.rng.choice([rate for rate in COMMANDS_HZ if control % rate == 0]))
    if d.robot == "hobby_arm":
        command, step = 50, COUNT_HOBBY / float(d.rng.choice([1, 2, 4]))
        noise = step * d.size(0.1, 0.5)
    traits = log_traits(d)
    traits["begin_s"] = np.floor(traits["begin_s"] * command) / command
    return {
        "gains": gains,
        "gravity_compensation": choices[d.rng.integers(len(choices))],
        "command_rate_hz": command,
        "control_rate_hz": control,
        "sample_rate_hz": int(d.rng.choice(SAMPLES_HZ)),
        "physics_rate_hz": PHYSICS_HZ,
        "duration_s": float(d.rng.choice([4.0, 4.5, 5.0, 5.5, 6.0])),
        "encoder_noise_rad": float(f"{noise:.3g}"),
        "encoder_resolution_rad": float(f"{step:.3g}"),
        "with_velocity": bool(d.rng.random() < 0.3),
        **{name: float(x) if name == "begin_s" else x for name, x in traits.items()},
    }


def _motions(d: Draw, settings: int) -> tuple[tuple, tuple]:
    """3 to 6 recordings to learn from and 2 held out: name, gains, motion, share of the size."""
    count = int(d.rng.integers(3, 7))
    kinds = [*d.rng.permutation(list(COMMANDS))[:count], *d.rng.permutation(list(COMMANDS))[:2]]
    # every setting is seen in training
    gains = [*(i % settings for i in range(count)), *d.rng.integers(settings, size=2)]
    rows = tuple(
        (f"{i + 1}_{kind}", int(gain), str(kind), d.between(0.5, 1.0))
        for i, (kind, gain) in enumerate(zip(kinds, gains, strict=True))
    )
    return rows[:count], rows[count:]


def _case(seed: int, group: str, robot: str, index: int) -> Case:
    rng = np.random.default_rng([seed, *f"{group} {robot} {index}".encode()])
    nominal, d = ROBOTS[robot], Draw(rng, robot)
    factor = d.size(*SCALE)
    mjcf = scaled(nominal.mjcf.read_text(), factor)
    loop = Loop.of(mjcf, nominal.joints, nominal.home, nominal.amplitude)
    changes = _setup(d, loop)
    train, holdout = _motions(d, len(changes["gains"]))
    draw = RobotDraw(rng, robot, loop, changes)
    hidden = ()
    if group.startswith("unknown"):
        hidden = (UNKNOWN[str(rng.choice(list(UNKNOWN)))](draw),)
        hidden += draw.known(1) if group == "unknown_and_known" else ()
    elif group == "known":
        hidden = draw.known(index % MOST_EFFECTS + 1)
    name = f"robots{seed}_{group}_{index + 1}_{robot}"
    return Case(name, robot, hidden, int(rng.integers(2**31)), changes, factor, train, holdout)


def cases_on_robots(seed: int) -> list[Case]:
    """The cases of a seed: on each robot, clean, unknown, unknown beside known, and known ones.

    The latter hide 1 to `MOST_EFFECTS` effects at once.
    """
    groups = {"clean": 1, "unknown": 1, "unknown_and_known": 1, "known": PER_ROBOT}
    return [
        _case(seed, group, robot, index)
        for group, count in groups.items()
        for index in range(count)
        for robot in NAMES
    ]
