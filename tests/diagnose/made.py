"""Small plants whose equations fit on a line, and recordings of them that no machine made."""

import dataclasses
from pathlib import Path

import numpy as np

from t2l.detective.linear_loop import linearised
from t2l.detective.motion import measured_motion
from t2l.detective.starting_points import read_off
from t2l.effects.registry import builtin
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor, Request
from t2l.recordings import Recording

MASS, LENGTH, GRAVITY = 0.5, 0.25, 9.81
ARMATURE, DAMPING = 0.005, 0.02
LINK = MASS * LENGTH**2 + 1e-4  # inertia about the axis, kg·m²
INERTIA = LINK + ARMATURE
WEIGHT = MASS * GRAVITY * LENGTH  # N·m when it points sideways

BODY = """<body pos="{x} 0 1"><joint name="{name}" axis="{axis}" {joint}/>
  <inertial pos="0 {y} {z}" mass="{mass}" diaginertia="1e-4 1e-4 1e-4"/>
  <site name="{site}" pos="0 {y} {z}"/></body>"""


def _body(name, axis="0 1 0", x=0.0, joint=None, site="attachment_site"):
    joint = joint or f'armature="{ARMATURE}" damping="{DAMPING}"'
    along = (0, -LENGTH) if axis == "0 1 0" else (LENGTH, 0)
    y, z = along
    return BODY.format(name=name, axis=axis, x=x, joint=joint, y=y, z=z, mass=MASS, site=site)


def _write(folder: Path, name: str, *bodies: str) -> str:
    path = folder / f"{name}.xml"
    path.write_text(
        f'<mujoco><compiler angle="radian"/><worldbody>{"".join(bodies)}</worldbody></mujoco>'
    )
    return str(path)


def pendulum(folder: Path, joint: str | None = None) -> str:
    """MJCF of a pendulum that hangs at zero; `joint`: attributes in place of the usual ones."""
    return _write(folder, "pendulum", _body("hinge", joint=joint))


def spinner(folder: Path, joint: str | None = None) -> str:
    """The same on a vertical axis, where gravity does nothing."""
    return _write(folder, "spinner", _body("hinge", axis="0 0 1", joint=joint))


def two_pendulums(folder: Path) -> str:
    """Two that do not feel each other."""
    joint = f'armature="{ARMATURE}" damping="{DAMPING}" frictionloss="0.01"'
    left = _body("left", joint=joint)
    right = _body("right", joint=joint, x=1.0, site="flange")
    return _write(folder, "two_pendulums", left, right)


def recording(robot, q_des, name="made", kp=20.0, kd=0.8, duration_s=1.0, **changes) -> Recording:
    """Commands `q_des(t)` (n, njoint), and a sample at each of 100 rows a second.

    What is measured is the first command throughout, until `measured` puts a prediction there.
    """
    rate = changes.pop("row_rate_hz", 100.0)
    time = np.arange(round(duration_s * rate) + 1) / rate
    commands = np.asarray(q_des(time), float).reshape(len(time), -1)
    njoint = commands.shape[1]
    made = Recording(
        name=name,
        path=None,
        robot=robot,
        joints=("hinge",) if njoint == 1 else ("left", "right"),
        kp=np.full(njoint, float(kp)),
        kd=np.full(njoint, float(kd)),
        command_rate_hz=rate,
        control_rate_hz=1000.0,
        gravity_compensation=False,
        time=time,
        q_des=commands,
        q=np.repeat(commands[:1], len(time), axis=0),
    )
    return dataclasses.replace(made, **changes)


def all_but(*names) -> tuple[str, ...]:
    """What `Model.without` names where only these effects are to be tried."""
    return tuple(sorted(set(builtin()) - set(names)))


def predict(recordings, effects=None, substeps=1, model=None) -> np.ndarray:
    """Predicted samples, with the effects ``{name: {parameter: value or {joint: value}}}``."""
    recordings = [recordings] if isinstance(recordings, Recording) else recordings
    model = model or Model(recordings[0].robot, effects or {})
    layout, u = model.vector(recordings[0].joints)
    predictor = Predictor(recordings[0].robot, recordings, substeps, threads=1)
    return predictor.predict([Request(layout, u[None])])[0][0]


def measured(
    of: Recording, effects=None, noise_rad=0.0, seed=0, model=None, substeps=1
) -> Recording:
    """The recording as a machine with these effects would have made it."""
    q = predict(of, effects, substeps, model).reshape(of.q.shape)
    return dataclasses.replace(
        of, q=q + noise_rad * np.random.default_rng(seed).normal(size=q.shape)
    )


def swing(amplitude=0.5, hz=0.8, offset=0.2):
    """A sum of two sines."""
    return lambda t: (
        offset + amplitude * (0.7 * np.sin(2 * np.pi * hz * t) + 0.3 * np.sin(5 * np.pi * hz * t))
    )


def hold(position):
    return lambda t: np.full(len(t), position)


def ramp(slope):
    return lambda t: slope * t


def step(size, at_s=0.1):
    return lambda t: np.where(t >= at_s, size, 0.0)


def swings(
    robot, effects=None, noise_rad=1e-4, duration_s=1.5, model=None, substeps=1, **changes
) -> list[Recording]:
    """Three recordings, from compliant to stiff, of a machine with these effects."""
    made = [
        recording(robot, swing(0.5, hz), f"kp{kp:g}", kp, kd, duration_s, **changes)
        for kp, kd, hz in ((5.0, 0.3, 0.7), (20.0, 0.8, 0.9), (80.0, 2.0, 1.1))
    ]
    return [measured(r, effects, noise_rad, seed, model, substeps) for seed, r in enumerate(made)]


def read(predictor: Predictor, base, effects):
    """What is read off the torque that a model (layout, u) lacks, see `read_off`."""
    sections = linearised(predictor, *base, measured_motion(predictor, *base))
    mask = np.ones(len(predictor.samples), bool)
    return read_off(predictor, sections, mask, base, base, effects)
