"""A test set: sizes, joints, robots, motions and logs drawn from a seed, none looked at before.

Sizes are drawn evenly in their logarithm, between what is barely visible and what dominates. Some
logs begin in motion, some come late, and some lack rows.
"""

from collections.abc import Callable

import numpy as np

from benchmarks.hidden_effects import effects as fx
from benchmarks.hidden_effects import real_effects as rx
from benchmarks.hidden_effects.generator import Logger

PENDULUM, ARM = "pendulum", "two_joint_arm"
JOINTS = {PENDULUM: ("hinge",), ARM: ("shoulder", "elbow")}
LINKS = {PENDULUM: ("bar",), ARM: ("upper_arm", "forearm")}
STRONGER = {"hinge": 1.0, "shoulder": 3.0, "elbow": 1.0}  # than the pendulum's torques
EACH = 2  # cases of a kind
OFTEN = 0.3  # share of the cases whose log has a trait
COMMAND_RATE_HZ = 50  # by which a log begins


class Draw:
    """Draws for one case."""

    def __init__(self, rng: np.random.Generator, robot: str):
        self.rng, self.robot = rng, robot

    def size(self, low: float, high: float) -> float:
        """Evenly in the logarithm, to three digits."""
        return float(f"{np.exp(self.rng.uniform(np.log(low), np.log(high))):.3g}")

    def signed(self, low: float, high: float) -> float:
        """Likewise, of either sign."""
        return float(self.rng.choice([-1, 1])) * self.size(low, high)

    def between(self, low: float, high: float) -> float:
        """Evenly."""
        return float(f"{self.rng.uniform(low, high):.3g}")

    def on_some(self, low: float, high: float) -> dict[str, float]:
        """A torque for some joints, at least one, larger for stronger joints."""
        joints = JOINTS[self.robot]
        count = self.rng.integers(1, len(joints) + 1)
        chosen = self.rng.choice(joints, count, replace=False)
        return {str(j): float(f"{STRONGER[j] * self.size(low, high):.3g}") for j in sorted(chosen)}

    def link(self) -> str:
        """One of the robot's."""
        return str(self.rng.choice(LINKS[self.robot]))


def _stribeck(d: Draw):
    coulomb = d.size(0.01, 0.08)
    return fx.StribeckFriction(coulomb, d.size(1.5, 4) * coulomb, d.size(0.03, 0.2))


def _lugre(d: Draw):
    coulomb = d.size(0.02, 0.1)
    static, presliding = d.size(1.2, 3) * coulomb, d.size(2e-3, 1e-2)
    return rx.LugreFriction(
        coulomb, static, d.size(0.05, 0.2), static / presliding, d.size(0.03, 0.2)
    )


def _coupling(d: Draw):
    return rx.JointCoupling(
        "elbow", "shoulder", d.size(0.1, 1.5), d.signed(0.3, 1.2), d.between(0, 1.2),
        d.size(0.002, 0.05),
    )  # fmt: skip


def _shift(d: Draw):
    return (d.signed(0.003, 0.03), 0.0, d.signed(0.005, 0.04))


def _direction(d: Draw):
    weak = d.size(0.01, 0.08)
    levels = (weak, d.size(1.5, 4) * weak)
    return rx.DirectionalFriction(*(levels if d.rng.random() < 0.5 else levels[::-1]))


KINDS: dict[str, tuple[tuple[str, ...], Callable[[Draw], fx.HiddenEffect]]] = {
    "armature": ((PENDULUM, ARM), lambda d: fx.Armature(d.on_some(0.001, 0.015))),
    "coulomb_friction": ((PENDULUM, ARM), lambda d: fx.CoulombFriction(d.on_some(0.01, 0.15))),
    "viscous_friction": ((PENDULUM, ARM), lambda d: fx.ViscousFriction(d.on_some(0.006, 0.1))),
    "quadratic_friction": ((PENDULUM, ARM), lambda d: fx.QuadraticFriction(d.on_some(0.005, 0.05))),
    "stribeck_friction": ((PENDULUM,), _stribeck),
    "load_dependent_friction": (
        (PENDULUM, ARM), lambda d: fx.LoadDependentFriction(d.size(0.03, 0.2))),
    "torque_offset": ((PENDULUM, ARM), lambda d: fx.TorqueOffset(d.on_some(0.01, 0.1))),
    "payload": ((PENDULUM, ARM), lambda d: fx.Payload(d.size(0.01, 0.3), _shift(d))),
    "torque_constant": ((PENDULUM, ARM), lambda d: fx.TorqueConstant(d.between(0.7, 0.97))),
    "command_delay": ((PENDULUM, ARM), lambda d: fx.CommandDelay(d.size(0.002, 0.03))),
    "clock_offset": ((PENDULUM, ARM), lambda d: rx.ClockOffset(d.size(0.002, 0.03))),
    "actuator_bandwidth": ((PENDULUM, ARM), lambda d: fx.ActuatorBandwidth(d.size(15, 60))),
    "torque_saturation": ((PENDULUM,), lambda d: fx.TorqueSaturation(d.size(1.1, 2.0))),
    "joint_flexibility": (
        (PENDULUM, ARM), lambda d: fx.JointFlexibility(d.on_some(30, 100), 0.05)),
    "backlash": ((PENDULUM, ARM), lambda d: fx.Backlash(d.on_some(0.02, 0.05))),
    "cogging": (
        (PENDULUM, ARM), lambda d: fx.Cogging(d.on_some(0.01, 0.08), d.between(8, 30))),
    "encoder_offset": ((PENDULUM,), lambda d: fx.EncoderOffset(d.signed(0.01, 0.06))),
    "controller_gains": (
        (PENDULUM, ARM), lambda d: fx.ControllerGains(d.size(0.8, 1.2), d.size(0.7, 1.4))),
    "low_rate_loop": ((PENDULUM,), lambda d: fx.LowRateLoop(float(d.rng.choice([125, 200, 250])))),
    "parallel_spring": (
        (PENDULUM, ARM), lambda d: rx.ParallelSpring(d.on_some(0.05, 1.0), d.between(-0.5, 1.2))),
    "base_tilt": (
        (PENDULUM, ARM), lambda d: rx.BaseTilt(d.signed(0.01, 0.1), d.signed(0.03, 0.3))),
    "link_inertia": (
        (PENDULUM, ARM),
        lambda d: rx.LinkInertia(d.link(), d.size(0.6, 1.7), _shift(d), d.size(0.7, 1.5))),
    "integral_action": (
        (PENDULUM,), lambda d: rx.IntegralAction(d.size(0.5, 20), d.size(0.2, 2))),
    "velocity_filter": ((PENDULUM, ARM), lambda d: rx.VelocityFilter(d.size(8, 50))),
    "joint_coupling": ((ARM,), _coupling),
    "dahl_friction": (
        (PENDULUM, ARM), lambda d: rx.DahlFriction(d.on_some(0.02, 0.15), d.size(2e-3, 3e-2))),
    "lugre_friction": ((PENDULUM,), _lugre),
    "directional_friction": ((PENDULUM,), _direction),
    "torque_speed_limit": (
        (PENDULUM,),
        lambda d: rx.TorqueSpeedLimit(d.size(1.3, 2.2), d.size(6, 15), 12.6, d.size(0.02, 0.1))),
    "periodic_torque": (
        (PENDULUM, ARM),
        lambda d: rx.PeriodicTorque(d.on_some(0.008, 0.1), d.size(0.3, 3), d.between(-3, 3))),
    "friction_drift": (
        (PENDULUM,),
        lambda d: rx.FrictionDrift(d.size(0.05, 0.15), d.size(0.01, 0.04), d.size(5, 20))),
    "torque_constant_drift": (
        (PENDULUM,),
        lambda d: rx.TorqueConstantDrift(1.0, d.between(0.6, 0.92), d.size(8, 25))),
    "friction_temperature": (
        (PENDULUM,),
        lambda d: rx.FrictionTemperature(level=d.size(0.04, 0.12), per_kelvin=-d.size(5e-4, 2e-3))),
    "torque_constant_temperature": (
        (PENDULUM,), lambda d: rx.TorqueConstantTemperature(per_kelvin=-d.size(1e-3, 6e-3))),
}  # fmt: skip


def log_traits(d: Draw) -> dict:
    """Changes of the setup: whether a log begins in motion, is late, lacks or repeats rows."""

    def some(value: float) -> float:
        return value if d.rng.random() < OFTEN else 0.0

    begin_s = some(float(d.rng.integers(30, 100) / COMMAND_RATE_HZ))
    logger = Logger(
        lateness_s=some(d.size(1e-4, 1e-3)),
        lost=some(d.size(5e-3, 5e-2)),
        repeated=some(d.size(2e-3, 2e-2)),
    )
    return {"begin_s": begin_s, "logger": logger}


def drawn(seed: int) -> list[tuple]:
    """(name, robot, hidden, seed, changes) of every case of a test set."""
    table = []
    for kind, (robots, make) in KINDS.items():
        for i in range(EACH):
            own = [seed, *kind.encode(), i]
            rng = np.random.default_rng(own)
            robot = str(rng.choice(robots))
            draw = Draw(rng, robot)
            hidden, number = make(draw), int(rng.integers(2**31))
            name = f"test{seed}_{kind}_{i + 1}_{robot}"
            table.append((name, robot, (hidden,), number, log_traits(draw)))
    for i in range(EACH):
        rng = np.random.default_rng([seed, 0, i])
        robot = str(rng.choice((PENDULUM, ARM)))
        name, number = f"test{seed}_clean_{i + 1}_{robot}", int(rng.integers(2**31))
        table.append((name, robot, (), number, log_traits(Draw(rng, robot))))
    return table
