"""The table of test cases: which robot hides what, and how it was recorded."""

import dataclasses
import hashlib
import re
import shutil
import zlib
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import yaml

from benchmarks.hidden_effects import real_cases
from benchmarks.hidden_effects.commands import COMMANDS
from benchmarks.hidden_effects.drawn_cases import drawn
from benchmarks.hidden_effects.effects import (
    ActuatorBandwidth,
    Armature,
    Backlash,
    Cogging,
    CommandDelay,
    ControllerGains,
    CoulombFriction,
    DriftingFriction,
    EncoderOffset,
    HiddenEffect,
    HysteresisTorque,
    JointFlexibility,
    LoadDependentFriction,
    LowRateLoop,
    OddPositionTorque,
    Payload,
    QuadraticFriction,
    StribeckFriction,
    TimeVaryingTorque,
    TorqueConstant,
    TorqueOffset,
    TorqueRateLimit,
    TorqueSaturation,
    ViscousFriction,
)
from benchmarks.hidden_effects.generator import (
    FR3_JOINTS,
    PUNCTUAL,
    Logger,
    fr3_mjcf,
    record,
    write,
)

ROBOTS_FOLDER = Path(__file__).parent / "robots"

# An effect is missing from its recording's model only if it moves the joints by more than this
# many times the encoder's noise.
VISIBLE = 3.0

# A joint that is ever this far from its command is out of control [rad].
OUT_OF_CONTROL = 1.5


@dataclass(frozen=True)
class Setup:
    """How a robot is recorded.

    Args:
        gains: settings (Kp, Kd), compliant to stiff, each one number or one per joint
            [N·m/rad, N·m·s/rad].
        gravity_compensation: whether the motors also cancel the nominal model's gravity: True at
            the controller's ticks, "continuous" at every physics step.
        command_rate_hz: rate of the commands.
        control_rate_hz: rate of the controller as the log tells it.
        sample_rate_hz: rate of the logged positions.
        physics_rate_hz: rate of integration.
        duration_s: length of each recording.
        encoder_noise_rad: standard deviation.
        encoder_resolution_rad: step of the logged positions.
        with_velocity: whether velocities are logged.
        begin_s: how long the robot moves before the recording begins.
        off_s: stretches of each recording in which the motors are off.
        torque_per_ampere: of the motors, whose current is logged; None where it is not [N·m/A].
        logger: what it does to the rows.
    """

    gains: tuple
    gravity_compensation: bool | str
    command_rate_hz: float = 50
    control_rate_hz: float = 1000
    sample_rate_hz: float = 200
    physics_rate_hz: float = 8000
    duration_s: float = 5.0
    encoder_noise_rad: float = 1e-4
    encoder_resolution_rad: float = 1e-4
    with_velocity: bool = False
    begin_s: float = 0.0
    off_s: tuple[tuple[float, float], ...] = ()
    torque_per_ampere: float | None = None
    logger: Logger = PUNCTUAL

    @property
    def noise_rms_rad(self) -> float:
        """Encoder noise and quantisation together."""
        return float(np.hypot(self.encoder_noise_rad, self.encoder_resolution_rad / 12**0.5))


@dataclass(frozen=True)
class Robot:
    """A robot, its home pose and the size of its motions [rad], and its usual setup.

    A slide counts in metres and newtons where a hinge counts in radians and newton metres. `mjcf`
    is a path, or the text of a robot whose masses were scaled.
    """

    mjcf: Path | str
    joints: tuple[str, ...]
    home: tuple[float, ...]
    amplitude: tuple[float, ...]
    setup: Setup


ROBOTS = {
    "pendulum": Robot(
        mjcf=ROBOTS_FOLDER / "pendulum.xml",
        joints=("hinge",),
        home=(0.3,),
        amplitude=(0.8,),
        setup=Setup(gains=((5.0, 0.3), (20.0, 0.8), (80.0, 2.0)), gravity_compensation=False),
    ),
    "two_joint_arm": Robot(
        mjcf=ROBOTS_FOLDER / "two_joint_arm.xml",
        joints=("shoulder", "elbow"),
        home=(0.4, 0.8),
        amplitude=(0.5, 0.7),
        setup=Setup(
            gains=(((12, 4), (1.0, 0.25)), ((40, 15), (2.0, 0.6)), ((150, 50), (5.0, 1.2))),
            gravity_compensation=True,
        ),
    ),
    "fr3": Robot(
        mjcf=fr3_mjcf(),
        joints=FR3_JOINTS,
        home=(0.0, -0.3, 0.0, -2.2, 0.0, 1.9, 0.785),
        amplitude=(0.2, 0.15, 0.2, 0.2, 0.25, 0.25, 0.3),
        setup=Setup(
            gains=((64.0, 8.0), (160.0, 12.0), (400.0, 24.0)),
            gravity_compensation=True,
            physics_rate_hz=4000,
            duration_s=4.0,
            encoder_noise_rad=5e-5,
            encoder_resolution_rad=2e-5,
        ),
    ),
}

# Robots of `drawn_robots`, which draws their setups: home, amplitude and one pair of gains.
for _name, _joints, _home, _amplitude, _kp, _kd in (
    (
        "ur5e",
        ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3"),
        (0.3, -1.2, 1.5, -1.8, -1.5, 0.2),
        (0.4, 0.3, 0.4, 0.5, 0.5, 0.6),
        (800, 800, 300, 30, 30, 25),
        (110, 110, 40, 3, 3, 2),
    ),
    (
        "quadruped_leg",
        ("abduction", "thigh", "knee"),
        (0.1, 0.8, -1.5),
        (0.3, 0.5, 0.6),
        (20, 20, 10),
        (1.5, 1.2, 0.5),
    ),
    (
        "scara",
        ("inner", "outer", "lift", "turn"),
        (0.4, 0.8, 0.0, 0.0),
        (0.5, 0.6, 0.06, 0.8),
        (300, 60, 1500, 4),
        (40, 8, 120, 0.3),
    ),
    (
        "hobby_arm",
        ("pan", "lift", "elbow", "wrist", "roll"),
        (0.1, -0.8, 1.2, 0.4, 0.2),
        (0.5, 0.4, 0.5, 0.5, 0.6),
        (6, 6, 5, 4, 4),
        (0.5, 0.5, 0.4, 0.3, 0.3),
    ),
    (
        "heavy_arm",
        ("swing", "boom", "jib"),
        (0.2, 0.1, 0.2),
        (0.4, 0.25, 0.3),
        (40000, 50000, 20000),
        (6000, 7000, 3000),
    ),
    (
        "light_arm",
        ("shoulder", "elbow"),
        (0.4, 0.6),
        (0.5, 0.6),
        (4e-3, 8e-4),
        (4e-4, 8e-5),
    ),
):
    ROBOTS[_name] = Robot(
        mjcf=ROBOTS_FOLDER / f"{_name}.xml",
        joints=_joints,
        home=_home,
        amplitude=_amplitude,
        setup=Setup(gains=((_kp, _kd),), gravity_compensation=True, physics_rate_hz=4000),
    )

for _variant in ("bare_pendulum", "rubbing_pendulum"):
    ROBOTS[_variant] = dataclasses.replace(
        ROBOTS["pendulum"], mjcf=ROBOTS_FOLDER / f"{_variant}.xml"
    )

# Name of the recording, which of the gain settings, what is commanded, share of the amplitude.
TRAIN = (
    ("compliant_multisine", 0, "multisine", 1.0),
    ("medium_triangle", 1, "triangle", 0.8),
    ("stiff_chirp", 2, "chirp", 0.8),
    ("medium_steps", 1, "steps", 0.5),
)
HOLDOUT = (
    ("stiff_multisine", 2, "multisine", 0.9),
    ("compliant_smooth_steps", 0, "smooth_steps", 0.8),
)


@dataclass(frozen=True)
class Case:
    """A robot that hides effects, none of them, one, or several.

    Args:
        name: of its folder.
        robot: key of `ROBOTS`.
        hidden: the effects that the model lacks.
        seed: of motions and noise.
        changes: fields of `Setup` that differ from the robot's usual one.
        mass_factor: by which all masses, armatures and dampings of the MJCF are multiplied.
        train, holdout: names of the recordings, which of the gains, what is commanded, share of
            the amplitude.
    """

    name: str
    robot: str
    hidden: tuple[HiddenEffect, ...] = ()
    seed: int = 0
    changes: dict = field(default_factory=dict)
    mass_factor: float = 1.0
    train: tuple[tuple[str, int, str, float], ...] = TRAIN
    holdout: tuple[tuple[str, int, str, float], ...] = HOLDOUT

    @property
    def nominal(self) -> Robot:
        """The robot without what is hidden, its masses scaled."""
        robot = ROBOTS[self.robot]
        if self.mass_factor == 1.0:
            return robot
        return dataclasses.replace(robot, mjcf=scaled(robot.mjcf.read_text(), self.mass_factor))

    @property
    def setup(self) -> Setup:
        """How this case is recorded."""
        return dataclasses.replace(ROBOTS[self.robot].setup, **self.changes)

    def truth(self) -> dict:
        """Everything that made the case, as plain data."""
        hidden = [{"effect": type(e).__name__, **dataclasses.asdict(e)} for e in self.hidden]
        facts = {
            "name": self.name,
            "robot": self.robot,
            "seed": self.seed,
            "mass_factor": self.mass_factor,
            "hidden": hidden,
            "setup": dataclasses.asdict(self.setup),
            "train": self.train,
            "holdout": self.holdout,
            "generator": generator_digest(),
        }
        return yaml.safe_load(yaml.safe_dump(_plain(facts)))


@cache
def generator_digest() -> str:
    """Of the code that makes the recordings: what other code made is made anew."""
    digest = hashlib.sha256()
    for name in ("commands", "effects", "real_effects", "generator"):
        digest.update((Path(__file__).parent / f"{name}.py").read_bytes())
    return digest.hexdigest()[:16]


def _plain(value):
    """Tuples as lists, which YAML can say."""
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items()}
    return [_plain(entry) for entry in value] if isinstance(value, list | tuple) else value


def scaled(mjcf: str, factor: float) -> str:
    """The text of an MJCF with all masses, armatures and dampings multiplied, to six digits.

    Torques along a motion are multiplied likewise: no motion under gains so scaled changes.
    """
    return re.sub(
        r'\b(mass|armature|damping)="([^"]+)"',
        lambda found: f'{found[1]}="{factor * float(found[2]):.6g}"',
        mjcf,
    )


def recording(case: Case, index: int, hidden: tuple[HiddenEffect, ...]) -> pd.DataFrame:
    """Recording `index` of a case's training and holdout together, as if the case hid `hidden`.

    Motions and noise are the same whatever is hidden.
    """
    robot, setup = case.nominal, case.setup
    _, gain, kind, share = (case.train + case.holdout)[index]
    kp, kd = setup.gains[gain]
    motion, noise = np.random.default_rng([case.seed, index]).spawn(2)
    moves_s = setup.begin_s + setup.duration_s
    move = COMMANDS[kind](motion, share * np.array(robot.amplitude), moves_s)
    return record(
        robot.mjcf,
        robot.joints,
        kp,
        kd,
        lambda t: np.array(robot.home) + move(t),
        duration_s=setup.duration_s,
        command_rate_hz=setup.command_rate_hz,
        control_rate_hz=setup.control_rate_hz,
        physics_rate_hz=setup.physics_rate_hz,
        gravity_compensation=setup.gravity_compensation,
        hidden=hidden,
        encoder_resolution_rad=setup.encoder_resolution_rad,
        encoder_noise_rad=setup.encoder_noise_rad,
        sample_rate_hz=setup.sample_rate_hz,
        rng=noise,
        with_velocity=setup.with_velocity,
        session_time_s=index * setup.duration_s,
        begin_s=setup.begin_s,
        off_s=setup.off_s,
        torque_per_ampere=setup.torque_per_ampere,
        logger=setup.logger,
    )


def is_complete(case: Case, folder: Path) -> bool:
    """Whether `make` has written this very case there."""
    path = folder / "truth.yaml"
    return path.exists() and yaml.safe_load(path.read_text()) == case.truth()


def make(case: Case, folder: Path) -> None:
    """Write a case's recordings to `folder`.

    `train/` and `holdout/` hold the recordings, beside the nominal MJCF of a small robot.
    `truth.yaml`, which says what is hidden, is written last.
    """
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    robot, setup = case.nominal, case.setup
    if case.robot == "fr3":
        model = "fr3"
    elif isinstance(robot.mjcf, Path):
        model = Path(shutil.copy(robot.mjcf, folder))
    else:
        model = folder / f"{case.robot}.xml"
        model.write_text(robot.mjcf)
    for index, (name, gain, _, _) in enumerate(case.train + case.holdout):
        part = "train" if index < len(case.train) else "holdout"
        kp, kd = setup.gains[gain]
        frame = recording(case, index, case.hidden)
        if worst_tracking_rad(frame) > OUT_OF_CONTROL:
            raise FloatingPointError(f"{case.name}: {name} is out of control")
        write(
            frame,
            folder / part / name,
            robot=model,
            joints=robot.joints,
            kp=kp,
            kd=kd,
            command_rate_hz=setup.command_rate_hz,
            control_rate_hz=setup.control_rate_hz,
            gravity_compensation=setup.gravity_compensation,
        )
    (folder / "truth.yaml").write_text(yaml.safe_dump(case.truth(), sort_keys=False))


def worst_tracking_rad(frame: pd.DataFrame) -> float:
    """The largest |q_des − q| of a recording, over its joints, until a motor is off."""
    if "torque_enabled" in frame:
        frame = frame[frame["torque_enabled"].cumprod() == 1]
    q = frame.filter(regex=r"^q\.").to_numpy()
    return float(np.nanmax(np.abs(frame.filter(regex=r"^q_des\.").to_numpy() - q)))


def visibility(case: Case, folder: Path) -> list[dict]:
    """How far each hidden effect moves the joints in the training recordings of `folder`.

    Returns:
        One row per effect: `ratio`, the RMS over all training recordings of the change of q when
        this effect alone is taken away, over the RMS of the encoder's noise, in the joint where
        it is largest; `worst_tracking_rad` of these recordings.
    """
    columns = [f"q.{joint}" for joint in ROBOTS[case.robot].joints]
    recorded = [pd.read_csv(folder / "train" / f"{name}.csv") for name, *_ in case.train]
    rows = []
    for effect in case.hidden:
        others = tuple(e for e in case.hidden if e is not effect)
        change = pd.concat(
            frame[columns] - recording(case, i, others)[columns] for i, frame in enumerate(recorded)
        )
        rms = np.sqrt((change**2).mean())
        rows.append(
            {
                "case": case.name,
                "effect": type(effect).__name__,
                "ratio": rms.max() / case.setup.noise_rms_rad,
                "joint": rms.idxmax()[2:],
                "worst_tracking_rad": max(map(worst_tracking_rad, recorded)),
            }
        )
    return rows


# ------------------------------------------------------------------------------------ the table

PENDULUM, ARM, FR3 = "pendulum", "two_joint_arm", "fr3"

WITHOUT_COMPENSATION = {"gravity_compensation": False}
IN_MOTION = {"begin_s": 1.3}
ARM_SOFT = {"gains": (((12, 4), (1.0, 0.25)), ((25, 8), (1.5, 0.4)), ((50, 16), (2.0, 0.6)))}
FR3_SOFT = {"gains": ((64.0, 6.0), (120.0, 8.0), (250.0, 10.0))}

# name of the effect, robot, effect, changes of the setup
SINGLES = (
    ("armature", PENDULUM, Armature(0.001), {}),
    ("armature", PENDULUM, Armature(0.004), {}),
    ("armature", PENDULUM, Armature(0.015), {}),
    ("armature", ARM, Armature({"elbow": 0.006}), {}),
    ("armature", FR3, Armature({"fr3_joint1": 0.3, "fr3_joint2": 0.3, "fr3_joint4": 0.2}), {}),
    ("coulomb_friction", PENDULUM, CoulombFriction(0.006), {}),
    ("coulomb_friction", PENDULUM, CoulombFriction(0.02), {}),
    ("coulomb_friction", PENDULUM, CoulombFriction(0.08), {}),
    ("coulomb_friction", PENDULUM, CoulombFriction(0.05, smooth_velocity=0.005), {}),
    ("coulomb_friction", ARM, CoulombFriction({"shoulder": 0.15, "elbow": 0.06}), {}),
    ("coulomb_friction", ARM, CoulombFriction({"elbow": 0.05}), {}),
    ("coulomb_friction", FR3, CoulombFriction({"fr3_joint4": 0.3, "fr3_joint7": 0.1}), {}),
    ("coulomb_friction", FR3, CoulombFriction(0.6), {}),
    ("viscous_friction", PENDULUM, ViscousFriction(0.006), {}),
    ("viscous_friction", PENDULUM, ViscousFriction(0.03), {}),
    ("viscous_friction", ARM, ViscousFriction({"shoulder": 0.2, "elbow": 0.08}), {}),
    ("viscous_friction", FR3, ViscousFriction(2.0), {}),
    ("quadratic_friction", PENDULUM, QuadraticFriction(0.004), {}),
    ("quadratic_friction", PENDULUM, QuadraticFriction(0.02), {}),
    ("quadratic_friction", ARM, QuadraticFriction({"shoulder": 0.1, "elbow": 0.04}), {}),
    ("quadratic_friction", FR3, QuadraticFriction(3.0), {}),
    ("stribeck_friction", PENDULUM, StribeckFriction(0.01, 0.03, 0.05), {}),
    ("stribeck_friction", PENDULUM, StribeckFriction(0.03, 0.08, 0.1), {}),
    ("stribeck_friction", ARM, StribeckFriction(0.05, 0.12, 0.2), {}),
    ("stribeck_friction", FR3, StribeckFriction(0.5, 1.5, 0.05), {}),
    ("load_dependent_friction", PENDULUM, LoadDependentFriction(0.03), {}),
    ("load_dependent_friction", PENDULUM, LoadDependentFriction(0.1), {}),
    (
        "load_dependent_friction",
        PENDULUM,
        LoadDependentFriction(0.2),
        {"sample_rate_hz": 250},
    ),
    ("load_dependent_friction", ARM, LoadDependentFriction(0.12, 0.01), {}),
    ("load_dependent_friction", FR3, LoadDependentFriction(0.06), {}),
    ("torque_offset", PENDULUM, TorqueOffset(-0.01), {}),
    ("torque_offset", PENDULUM, TorqueOffset(0.03), {}),
    ("torque_offset", ARM, TorqueOffset({"shoulder": 0.2, "elbow": -0.05}), {}),
    ("torque_offset", FR3, TorqueOffset({"fr3_joint2": 0.8, "fr3_joint4": -0.6}), {}),
    ("payload", PENDULUM, Payload(0.008), {}),
    ("payload", PENDULUM, Payload(0.05), {}),
    ("payload", ARM, Payload(0.08, com=(0.0, 0.0, -0.03)), {}),
    ("payload", ARM, Payload(0.2, com=(0.02, 0.0, -0.02)), WITHOUT_COMPENSATION),
    ("payload", FR3, Payload(0.5, com=(0.0, 0.0, 0.06), radius=0.04), {}),
    ("payload", FR3, Payload(1.2, com=(0.03, 0.0, 0.08), radius=0.05), {}),
    ("torque_constant", PENDULUM, TorqueConstant(0.98), {}),
    ("torque_constant", PENDULUM, TorqueConstant(0.88), {}),
    ("torque_constant", ARM, TorqueConstant({"shoulder": 1.1}), {}),
    ("torque_constant", FR3, TorqueConstant(0.96), {}),
    ("command_delay", PENDULUM, CommandDelay(0.001), {}),
    ("command_delay", PENDULUM, CommandDelay(0.004), {}),
    ("command_delay", ARM, CommandDelay(0.015), {}),
    ("command_delay", FR3, CommandDelay(0.008), {}),
    ("actuator_bandwidth", PENDULUM, ActuatorBandwidth(60.0), {}),
    ("actuator_bandwidth", PENDULUM, ActuatorBandwidth(12.0), {}),
    ("actuator_bandwidth", ARM, ActuatorBandwidth(20.0), {}),
    ("actuator_bandwidth", FR3, ActuatorBandwidth(15.0), {}),
    ("torque_saturation", PENDULUM, TorqueSaturation(2.0), {}),
    ("torque_saturation", PENDULUM, TorqueSaturation(1.2), {}),
    ("torque_saturation", ARM, TorqueSaturation({"shoulder": 5.0, "elbow": 1.5}), {}),
    ("torque_saturation", FR3, TorqueSaturation({"fr3_joint4": 26.0, "fr3_joint6": 5.0}), {}),
    ("torque_rate_limit", PENDULUM, TorqueRateLimit(300.0), {}),
    ("torque_rate_limit", ARM, TorqueRateLimit({"shoulder": 600.0, "elbow": 200.0}), {}),
    ("torque_rate_limit", FR3, TorqueRateLimit(500.0), {}),
    ("joint_flexibility", PENDULUM, JointFlexibility(100.0, 0.03), {}),
    ("joint_flexibility", PENDULUM, JointFlexibility(30.0, 0.03), {}),
    ("joint_flexibility", ARM, JointFlexibility({"shoulder": 80.0, "elbow": 30.0}, 0.05), {}),
    ("joint_flexibility", ARM, JointFlexibility({"elbow": 100.0}, 0.2, "link"), ARM_SOFT),
    (
        "joint_flexibility",
        FR3,
        JointFlexibility({"fr3_joint2": 1500.0, "fr3_joint4": 1000.0}, 2.0),
        {},
    ),
    ("joint_flexibility", PENDULUM, JointFlexibility(30.0, 0.03), IN_MOTION),
    (
        "joint_flexibility",
        ARM,
        JointFlexibility({"shoulder": 80.0, "elbow": 30.0}, 0.05),
        IN_MOTION,
    ),
    ("backlash", PENDULUM, Backlash(0.01), {}),
    ("backlash", PENDULUM, Backlash(0.03), {}),
    ("backlash", PENDULUM, Backlash(0.02), {"gravity_compensation": True}),
    ("backlash", ARM, Backlash({"elbow": 0.03}), {}),
    ("backlash", FR3, Backlash({"fr3_joint1": 0.02}), {}),
    ("backlash", ARM, Backlash({"elbow": 0.06}), {}),
    ("backlash", ARM, Backlash({"elbow": 0.15}), {}),
    ("backlash", ARM, Backlash({"shoulder": 0.05}), {}),
    ("backlash", FR3, Backlash({"fr3_joint4": 0.03}), {}),
    ("backlash", FR3, Backlash({"fr3_joint6": 0.1}), {}),
    ("backlash", PENDULUM, Backlash(0.03), IN_MOTION),
    ("backlash", ARM, Backlash({"elbow": 0.06}), IN_MOTION),
    ("cogging", PENDULUM, Cogging(0.01, 10), {}),
    ("cogging", PENDULUM, Cogging(0.05, 14), {}),
    ("cogging", ARM, Cogging({"shoulder": 0.15, "elbow": 0.06}, 20, 0.7), {}),
    ("cogging", FR3, Cogging(0.5, 25, 0.3), {}),
    ("encoder_offset", PENDULUM, EncoderOffset(0.02), {}),
    (
        "encoder_offset",
        ARM,
        EncoderOffset({"shoulder": 0.02, "elbow": -0.03}),
        WITHOUT_COMPENSATION,
    ),
    ("encoder_offset", FR3, EncoderOffset({"fr3_joint4": 0.02}), WITHOUT_COMPENSATION),
    ("controller_gains", PENDULUM, ControllerGains(1.0, 0.95), {}),
    ("controller_gains", PENDULUM, ControllerGains(0.9, 1.0), {}),
    ("controller_gains", ARM, ControllerGains(1.0, 1.25), {}),
    ("controller_gains", FR3, ControllerGains(1.1, 0.85), {}),
    (
        "low_rate_loop",
        PENDULUM,
        LowRateLoop(100.0),
        {"gains": ((5.0, 0.3), (15.0, 0.6), (40.0, 1.2))},
    ),
    ("low_rate_loop", PENDULUM, LowRateLoop(200.0), {}),
    ("low_rate_loop", ARM, LowRateLoop(200.0), ARM_SOFT),
    ("low_rate_loop", FR3, LowRateLoop(100.0), FR3_SOFT),
    ("drifting_friction", PENDULUM, DriftingFriction(0.06, 0.02, 8.0), {}),
    ("drifting_friction", ARM, DriftingFriction({"elbow": 0.03}, {"elbow": 0.09}, 10.0), {}),
    ("odd_position_torque", PENDULUM, OddPositionTorque(0.06, 0.5, 0.1, 0.3, 0.6), {}),
    (
        "odd_position_torque",
        ARM,
        OddPositionTorque({"elbow": 0.06}, 1.0, 0.1, 0.8, 0.5),
        {},
    ),
    ("time_varying_torque", PENDULUM, TimeVaryingTorque(0.04, 0.73), {}),
    ("time_varying_torque", FR3, TimeVaryingTorque({"fr3_joint4": 1.0}, 0.41, 0.5), {}),
    ("hysteresis_torque", PENDULUM, HysteresisTorque(0.06, 0.2), {}),
    ("hysteresis_torque", ARM, HysteresisTorque({"shoulder": 0.2, "elbow": 0.06}, 0.15), {}),
)

PAIRS = (
    (PENDULUM, (CoulombFriction(0.05), CommandDelay(0.01)), {}),
    (PENDULUM, (Armature(0.01), ViscousFriction(0.05)), {}),
    (PENDULUM, (TorqueConstant(0.9), CoulombFriction(0.06)), {}),
    (PENDULUM, (Cogging(0.06, 11, 0.4), TorqueOffset(0.05)), {}),
    (ARM, (Payload(0.1), CoulombFriction({"shoulder": 0.12, "elbow": 0.05})), {}),
    (ARM, (ActuatorBandwidth(25.0), TorqueOffset({"elbow": 0.06})), {}),
    (ARM, (StribeckFriction(0.05, 0.1, 0.15), CommandDelay(0.01)), {}),
    (ARM, (Backlash({"elbow": 0.03}), ViscousFriction({"shoulder": 0.2})), {}),
    (FR3, (CoulombFriction(0.6), Payload(0.6, com=(0.0, 0.0, 0.05))), {}),
    (FR3, (TorqueOffset({"fr3_joint2": 0.8}), ViscousFriction(2.0)), {}),
    (FR3, (LoadDependentFriction(0.05), CommandDelay(0.01)), {}),
)

CLEAN = (
    ("pendulum", PENDULUM, {}),
    ("pendulum_quiet", PENDULUM, {"encoder_noise_rad": 2e-5, "encoder_resolution_rad": 1e-5}),
    ("pendulum_compensated", PENDULUM, {"gravity_compensation": True, "command_rate_hz": 20}),
    ("pendulum_500_hz", PENDULUM, {"control_rate_hz": 500, "sample_rate_hz": 100}),
    (
        "arm_stiff",
        ARM,
        {"gains": (((60, 25), (3.0, 0.8)), ((150, 60), (5.0, 1.4)), ((300, 120), (8.0, 2.2)))},
    ),
    ("arm_500_hz", ARM, {"control_rate_hz": 500, "command_rate_hz": 100, "with_velocity": True}),
    ("arm_250_hz", ARM, {"control_rate_hz": 250, "sample_rate_hz": 250} | WITHOUT_COMPENSATION),
    ("pendulum_held", PENDULUM, {"gravity_compensation": True}),
    ("pendulum_balanced", PENDULUM, {"gravity_compensation": "continuous"}),
    ("arm_250_hz_held", ARM, {"control_rate_hz": 250}),
    ("arm_balanced", ARM, {"gravity_compensation": "continuous"}),
    ("arm_slow_recorder", ARM, {"sample_rate_hz": 40, "encoder_noise_rad": 2e-4}),
    ("fr3", FR3, {}),
    ("pendulum_late_rows", PENDULUM, {"logger": Logger(lateness_s=1e-3)} | IN_MOTION),
    (
        "arm_real_log",
        ARM,
        {"logger": Logger(5e-4, lost=0.05, repeated=0.02), "torque_per_ampere": 0.8},
    ),
    ("arm_lost_commands", ARM, {"logger": Logger(lost=0.01, lost_commands=0.01)}),
    ("pendulum_blurred_stamps", PENDULUM, {"logger": Logger(stamp_error_s=2e-5)}),
    (
        "pendulum_switched_off",
        PENDULUM,
        {"off_s": ((2.0, 3.2),), "torque_per_ampere": 0.3, "gravity_compensation": True},
    ),
    (
        "arm_switched_off",
        ARM,
        {"off_s": ((3.0, 5.0),), "logger": Logger(5e-4), "gravity_compensation": "continuous"},
    ),
    (
        "fr3_underdamped",
        FR3,
        {"gains": ((64.0, 4.0), (150.0, 5.0), (400.0, 8.0)), "encoder_noise_rad": 1e-4},
    ),
)


def cases(test_seed: int | None = None) -> list[Case]:
    """The development cases, or the test cases of a seed.

    Development has single effects, pairs and clean robots; each case's seed follows from its name.
    """
    if test_seed is not None:
        return [Case(*drawn_case) for drawn_case in drawn(test_seed)]
    table = []
    count = {}
    for effect, robot, hidden, changes in (*SINGLES, *real_cases.REAL):
        count[effect] = count.get(effect, 0) + 1
        table.append((f"{effect}_{count[effect]}_{robot}", robot, (hidden,), changes))
    for i, (robot, hidden, changes) in enumerate(PAIRS, start=1):
        table.append((f"pair_{i}_{robot}", robot, hidden, changes))
    for name, robot, changes in (*CLEAN, *real_cases.CLEAN):
        table.append((f"clean_{name}", robot, (), changes))
    return [
        Case(name, robot, hidden, zlib.crc32(name.encode()), changes)
        for name, robot, hidden, changes in table
    ]
