"""Joints under noise on their commands, every cell and replicate in one batch of simulations.

A simulation is a rack: several copies of a bare joint of each inertia and of a robot's last joint,
which do not touch. MuJoCo's cost of a step hardly grows with the first ten joints, so that copies
are the cheaper replicates.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
import pandas as pd

from t2l.advise.attenuation import (
    attenuation,
    continuous_matrices,
    held_variance,
    step_matrices,
    time_constant_s,
)
from t2l.gains import Cell
from t2l.robots import plant
from t2l.robots.robot import Robot
from t2l.sim import apply_position_gains, diverged, make_batch
from t2l.sim.batch import TIMESTEP_S

COLUMNS = (
    *("plant", "inertia_kg_m2", "kp", "kd", "hold_s", "noise_rad", "replicates"),
    *("variance_rad2", "variance_rad2_se", "theorem_rad2", "exact_rad2", "continuous_rad2"),
)
COPIES = 4
# of the slowest motion: a start at rest then still lacks e⁻⁷ = 0.1 % of the variance
SETTLING_TIME_CONSTANTS = 3.5
# nothing but a place to mount an armature on
_MASS_KG, _INERTIA_KG_M2 = 1e-6, 1e-9


@dataclass(frozen=True)
class Rack:
    """Joints that do not touch, of several plants.

    Attributes:
        model: in which each joint has a position actuator of its own name.
        joints: names of the copies of each plant.
        inertia: of each plant about its joint, kg·m².
    """

    model: mujoco.MjModel
    joints: Mapping[str, tuple[str, ...]]
    inertia: Mapping[str, float]


def make_rack(robot: Robot, inertias: Sequence[float], copies: int = COPIES) -> Rack:
    """Bare joints and a robot's last joint, its others held at their reference positions.

    Only the controller damps: the MJCF's friction, damping and limits are taken out.

    Args:
        inertias: of the bare joints, kg·m².
    """
    spec = _free(mujoco.MjSpec())
    spec.compiler.fusestatic = True
    joints: dict[str, list[str]] = {}
    for inertia in inertias:
        name = bare_name(inertia)
        joints[name] = [f"{name}.{copy}" for copy in range(copies)]
        for joint in joints[name]:
            body = spec.worldbody.add_body(
                mass=_MASS_KG, inertia=[_INERTIA_KG_M2] * 3, explicitinertial=True
            )
            body.add_joint(name=joint, type=mujoco.mjtJoint.mjJNT_HINGE, armature=inertia)
    last = robot.joints[-1]
    joints[last] = [f"{copy}.{last}" for copy in range(copies)]
    for copy in range(copies):
        arm = _free(plant.load(robot.name, (last,)))
        arm.joint(last).damping = np.zeros_like(arm.joint(last).damping)
        arm.joint(last).actfrclimited = 0
        spec.attach(arm, prefix=f"{copy}.", frame=spec.worldbody.add_frame())
    for joint in [name for names in joints.values() for name in names]:
        actuator = spec.add_actuator(name=joint, target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        actuator.set_to_position(kp=1.0, kv=1.0)
    model = spec.compile()
    first = {name: model.joint(names[0]).dofadr[0] for name, names in joints.items()}
    return Rack(
        model=model,
        joints={name: tuple(names) for name, names in joints.items()},
        inertia={name: float(model.dof_M0[dof]) for name, dof in first.items()},
    )


def _free(spec: mujoco.MjSpec) -> mujoco.MjSpec:
    """The same, with the options of `t2l.sim` and without anything that constrains a joint."""
    off = mujoco.mjtDisableBit
    spec.option.timestep = TIMESTEP_S
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_DISCRETE
    spec.option.solver = mujoco.mjtSolver.mjSOL_NEWTON
    spec.option.disableflags |= off.mjDSBL_CONTACT | off.mjDSBL_CONSTRAINT | off.mjDSBL_GRAVITY
    return spec


def bare_name(inertia: float) -> str:
    """What a bare joint is called in tables."""
    return f"joint of {inertia:g} kg·m²"


def held_noise(
    rack: Rack,
    cells: Sequence[Cell],
    noise_rad: float,
    steps: int,
    replicates: int,
    time_constants: float,
    rng: np.random.Generator,
    threads: int = 1,
) -> pd.DataFrame:
    """Variance of the position of joints that hold a pose under noise on what is commanded.

    Each cell is simulated for its own time constant: first until a start at rest is forgotten,
    then `time_constants` of them, in which the squared position is averaged over every timestep.

    Args:
        noise_rad: standard deviation σ of Gaussian noise, drawn anew for every command.
        steps: timesteps of 2 ms that a command is held for.
        replicates: of each joint in each cell, rounded up to a multiple of the rack's copies.

    Returns:
        One row a plant and cell, columns `COLUMNS`: the variance about the commanded pose with its
        standard error over replicates, the theorem's, the exact one of the simulated joint, and
        that of a joint in continuous time.
    """
    copies = len(next(iter(rack.joints.values())))
    each = -(-replicates // copies)
    names = [name for joints in rack.joints.values() for name in joints]
    gains = np.repeat([(cell.kp, cell.kd) for cell in cells], each, axis=0)
    batch = make_batch(rack.model, len(gains), threads)
    apply_position_gains(batch, names, gains[:, :1], gains[:, 1:])
    qpos, ctrl = batch.bind("qpos"), batch.bind("ctrl")
    columns = np.array([rack.model.joint(name).qposadr[0] for name in names])
    slowest = [
        max(time_constant_s(cell.kp, cell.kd, m, TIMESTEP_S) for m in rack.inertia.values())
        for cell in cells
    ]
    holds = np.repeat(slowest, each) / (steps * TIMESTEP_S)
    begin = np.ceil(SETTLING_TIME_CONSTANTS * holds).astype(int)
    end = begin + np.ceil(time_constants * holds).astype(int)
    squares = np.zeros((len(gains), len(names)))
    for hold in range(int(end.max())):
        running = hold < end
        ctrl[running] = rng.normal(0.0, noise_rad, (running.sum(), len(names)))
        measured = running & (hold >= begin)
        for _ in range(steps):
            batch.step(ids=running)
            squares[measured] += qpos[measured][:, columns] ** 2
    squares /= ((end - begin) * steps)[:, None]
    squares[diverged(batch)] = np.nan
    by_cell = squares.reshape(len(cells), each, len(rack.joints), copies)
    return _table(rack, cells, by_cell.transpose(2, 0, 1, 3), noise_rad, steps)


def _table(
    rack: Rack, cells: Sequence[Cell], squares: np.ndarray, noise_rad: float, steps: int
) -> pd.DataFrame:
    rows = []
    hold_s = steps * TIMESTEP_S
    for plant_squares, (name, inertia) in zip(squares, rack.inertia.items(), strict=True):
        for values, cell in zip(plant_squares, cells, strict=True):
            n = values.size
            error = values.std(ddof=1) / np.sqrt(n) if n > 1 else np.nan
            joint = (cell.kp, cell.kd, inertia, TIMESTEP_S)
            theory = noise_rad**2 * np.array(
                [
                    attenuation(cell.kp, cell.kd, hold_s),
                    held_variance(*step_matrices(*joint), steps),
                    held_variance(*continuous_matrices(*joint), steps),
                ]
            )
            rows.append(
                (
                    *(name, inertia, cell.kp, cell.kd, hold_s, noise_rad, n),
                    *(values.mean(), error, *theory),
                )
            )
    return pd.DataFrame(rows, columns=list(COLUMNS))
