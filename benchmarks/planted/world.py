"""A world: a robot, what its model lacks, a motion it is to make, and the gains in question."""

from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from benchmarks.hidden_effects.cases import ROBOTS, scaled
from benchmarks.hidden_effects.drawn_robots import KINDS, LOOPS_HZ, Loop, RobotDraw
from benchmarks.hidden_effects.effects import HiddenEffect
from benchmarks.hidden_effects.generator import read

NAMES = ("fr3", "ur5e", "hobby_arm", "quadruped_leg")
EACH = 6  # worlds of a robot, half of each for development
LOOPS = {"fr3": (1000,), "ur5e": (500,), "hobby_arm": (200,), "quadruped_leg": (500, 1000)}
EFFECTS = 3  # of each world, of different groups
# what `t2l explain` has a name for, and a person would expect of a machine
PLANTED = (
    "armature", "coulomb_friction", "stribeck_friction", "viscous_friction", "torque_offset",
    "parallel_spring", "payload", "torque_constant", "controller_gains",
    "command_delay", "actuator_bandwidth", "velocity_filter", "low_rate_loop", "joint_flexibility",
    "backlash",
)  # fmt: skip
SIZES = (0.5, 2.0)  # of masses, but of the FR3, whose inertias are explicit
# of a joint of mean inertia, of those that `t2l advise` looks at
FREQUENCIES_HZ = 1.25 * 2.0 ** np.arange(4)
DAMPINGS = 2.0 ** np.arange(-2, 2)  # of critical at the middle of them
TOLERANCES = (0.05, 0.12)  # share of the reach
RECORDED_HZ = (2.5, 5.0)  # natural frequency of the critically damped loop of the demonstrations


@dataclass(frozen=True)
class World:
    """One of them; arrays are (joints,).

    Attributes:
        name: with the robot's.
        robot: key of `ROBOTS`.
        seed: of all episodes.
        mjcf: text of the nominal model.
        joints: names.
        hidden: what it lacks.
        home, reach: about which, and how far it moves [rad].
        via, goal: the middle of these from home, in shares of `reach`.
        tolerance: of both places, RMS over joints of shares of `reach`.
        seconds: that a person takes from one to the next.
        recorded_kp, recorded_kd: gains of the demonstrations, one for each joint.
        usual_kp, usual_kd: gains that such a robot is used with.
        kp, kd: (4,) each, the gains in question, every Kp with every Kd on all joints.
        control_rate_hz: of its loop.
        noise_rad, step_rad: of encoders.
    """

    name: str
    robot: str
    seed: int
    mjcf: str
    joints: tuple[str, ...]
    hidden: tuple[HiddenEffect, ...]
    home: np.ndarray
    reach: np.ndarray
    via: np.ndarray
    goal: np.ndarray
    tolerance: float
    seconds: float
    recorded_kp: np.ndarray
    recorded_kd: np.ndarray
    usual_kp: np.ndarray
    usual_kd: np.ndarray
    kp: np.ndarray
    kd: np.ndarray
    control_rate_hz: int
    noise_rad: float
    step_rad: float

    @property
    def cells(self) -> list[tuple[float, float]]:
        """Pairs (Kp, Kd) by Kd, then by Kp."""
        return [(float(kp), float(kd)) for kd in self.kd for kp in self.kp]

    @property
    def development(self) -> bool:
        """Whether code may be fitted to it."""
        return int(self.name.rsplit("_", 1)[1]) < EACH // 2

    def rng(self, *what: int) -> np.random.Generator:
        """For one of its parts."""
        return np.random.default_rng([self.seed, *what])


def drawn(seed: int, robot: str, index: int, again: int = 0) -> World:
    """One of them.

    Args:
        again: how often it was drawn before.
    """
    rng = np.random.default_rng([seed, again, *f"planted {robot} {index}".encode()])
    nominal = ROBOTS[robot]
    factor = 1.0 if robot == "fr3" else float(np.exp(rng.uniform(*np.log(SIZES))))
    mjcf = scaled(bare(nominal.mjcf), factor)
    loop = Loop.of(mjcf, nominal.joints, nominal.home, nominal.amplitude)
    inertia = np.diag(loop.mass)
    omega = 2 * np.pi * np.exp(rng.uniform(*np.log(RECORDED_HZ)))
    kp, kd = inertia * omega**2, 2 * inertia * omega
    noise, step = np.exp(rng.uniform(np.log(1e-5), np.log(3e-4))), 2e-5
    if robot == "hobby_arm":
        step = 2 * np.pi / 4096
        noise = 0.3 * step
    changes = {
        "gains": ((tuple(kp), tuple(kd)),), "encoder_noise_rad": noise,
        "encoder_resolution_rad": step, "gravity_compensation": True,
        "control_rate_hz": int(rng.choice(LOOPS.get(robot, LOOPS_HZ.get(robot)))),
    }  # fmt: skip
    draw, hidden, groups = RobotDraw(rng, robot, loop, changes), [], set()
    for kind in rng.permutation(list(PLANTED)).tolist():
        group, make = KINDS[kind]
        if len(hidden) < EFFECTS and group not in groups and draw.possible(kind):
            hidden.append(make(draw))
            groups.add(group)
    n = len(nominal.joints)
    mean = np.exp(np.log(inertia).mean())
    stiff = mean * (2 * np.pi * FREQUENCIES_HZ) ** 2
    damp = 2 * mean * 2 * np.pi * np.sqrt(FREQUENCIES_HZ[1] * FREQUENCIES_HZ[2]) * DAMPINGS
    side = rng.choice([-1.0, 1.0], n)
    usual = [np.array(gain) * np.ones(n) * factor for gain in _usual(nominal.setup.gains)]
    return World(
        f"{robot}_{index}", robot, int(rng.integers(2**31)), mjcf, nominal.joints, tuple(hidden),
        np.array(nominal.home), np.array(nominal.amplitude), side * rng.uniform(0.5, 1.2, n),
        -side * rng.uniform(0.0, 1.0, n), float(np.exp(rng.uniform(*np.log(TOLERANCES)))),
        float(rng.uniform(0.7, 1.1)), kp, kd, *usual,
        *(np.array([float(f"{x:.2g}") for x in gain]) for gain in (stiff, damp)),
        changes["control_rate_hz"], float(noise), step,
    )  # fmt: skip


def _usual(gains: tuple) -> tuple:
    return gains[len(gains) // 2]


def bare(mjcf: Path) -> str:
    """The text of a model without what it looks like and touches with."""
    spec = read(mjcf)
    for geom in [g for g in spec.geoms if g.type == mujoco.mjtGeom.mjGEOM_MESH]:
        spec.delete(geom)
    if not spec.meshes:
        return mjcf.read_text()
    for element in [*spec.meshes, *spec.excludes, *spec.keys, *spec.materials, *spec.textures]:
        spec.delete(element)
    spec.compile()
    return spec.to_xml()
