"""What a model says of a robot's loop, as numbers: plants at poses, signals, weights, friction.

Effects that bend the loop's linear response are taken over; `LINEAR` names them. What friction and
limits do beside that is told apart: friction as a sag, limits by the replay.
"""

from dataclasses import dataclass, replace

import mujoco
import numpy as np

from t2l.advise.loop import Plant, Signals
from t2l.identify.model import Model
from t2l.identify.prediction import with_effects
from t2l.identify.simulation import made_loop
from t2l.sim.loop import torque_limits
from t2l.sim.schedule import Schedule

STEP_RAD = 1e-6  # numerics: of finite differences
# of what a model may hold, all that this package's linear loop has; springs are in the plant
LINEAR = (
    "torque_delay", "measurement_delay", "command_delay", "velocity_filter", "actuator_bandwidth",
    "low_rate_loop", "controller_gains", "armature", "viscous_friction", "joint_flexibility",
    "payload", "link_inertia", "parallel_spring", "coulomb_friction",
)  # fmt: skip


@dataclass(frozen=True)
class Machine:
    """A robot at poses, of n joints.

    Attributes:
        joints: names.
        rate_hz: of the control loop.
        compensated: whether the controller carries the weight of the joints.
        plant: k poses.
        of_joint: (m,) which joint each degree of freedom of the plant is on the axis of.
        signals: of the loop.
        gain_factor: (n, 2) on Kp and Kd, as the machine has them.
        weight: (k, n) N·m that gravity asks of each joint.
        friction: (n,) N·m of dry friction that holds a joint at rest.
        torque_limit: (n,) N·m, infinite where the file states none.
        left_out: titles of effects that the linear loop does not have.
    """

    joints: tuple[str, ...]
    rate_hz: float
    compensated: bool
    plant: Plant
    of_joint: np.ndarray
    signals: Signals
    gain_factor: np.ndarray
    weight: np.ndarray
    friction: np.ndarray
    torque_limit: np.ndarray
    left_out: tuple[str, ...]

    @property
    def inertia(self) -> np.ndarray:
        """(k, n) kg·m² that each joint moves with all that hangs on it, the others held."""
        driven = self.plant.drive.argmax(axis=0)
        return self.plant.mass[:, driven, driven]

    def real(self, kp: np.ndarray, kd: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The gains (cell, n) that it has where it is told these."""
        return self.gain_factor[:, 0] * kp, self.gain_factor[:, 1] * kd

    def alone(self, joint: int) -> Plant:
        """The plants of one joint, the others held: it and what gives on its axis."""
        own = np.flatnonzero(self.of_joint == joint)
        both = np.ix_(np.arange(len(self.plant.mass)), own, own)
        return Plant(
            self.plant.mass[both], self.plant.damping[:, own], self.plant.stiffness[both],
            self.plant.drive[own, joint : joint + 1], self.plant.sense[joint : joint + 1, own],
        )  # fmt: skip


def of_model(
    model: Model,
    joints: tuple[str, ...],
    poses: np.ndarray,
    rate_hz: float,
    compensated: bool,
    limits: np.ndarray | None = None,
) -> Machine:
    """What a model with its effects is at poses (k, n) rad.

    Args:
        compensated: whether the controller carries the weight.
        limits: (n,) N·m, where more is known than the robot's file says.

    Raises:
        ConfigurationError: the robot's file is wrong, or lacks a joint.
    """
    left_out = _left_out(model, joints)
    # play between two masses, of which none holds the other, has no linear loop
    model = replace(model, effects={k: v for k, v in model.effects.items() if k in LINEAR})
    layout, u = model.vector(joints)
    extending = [term for term in layout.terms if term.effect.extends]
    compiled = with_effects(model.robot, joints, extending)
    held = np.zeros_like(poses)
    still = np.zeros(len(poses), bool)
    schedule = Schedule(
        period_s=1 / rate_hz, commands=np.stack([poses] * 2), kp=held + 1.0, kd=held + 1.0,
        start_q=poses, start_dq=held, compensated=still, balanced=still,
        sample_ticks=np.array([0, 1]),
    )  # fmt: skip
    loop = made_loop(compiled, joints, schedule, 1, [(layout, u[None])], 1)
    parts = [_plant(loop.batch.get_model(i), loop, q) for i, q in enumerate(poses)]
    mass, damping, stiffness, weight = map(np.array, zip(*parts, strict=True))
    n, m = len(joints), compiled.nv
    drive = np.zeros((m, n))
    drive[loop.dofs, np.arange(n)] = 1.0
    sense = drive.T.copy()
    gives = model.effects.get("joint_flexibility", {})
    for j, joint in enumerate(joints):
        if joint in gives.get("stiffness", {}):
            between = compiled.joint(f"{joint}/flexibility").dofadr[0]
            sense[j, between] = gives["encoder_on_link"]
    leaning = np.array([_leaning(loop, q) for q in poses])
    if compensated:
        # the motor carries the weight; what a spring bends under it stays
        weight, leaning[:, loop.dofs] = np.zeros_like(weight), 0.0
    stiffness = stiffness + leaning
    stated = abs(torque_limits(compiled, joints)).min(axis=1)
    friction = compiled.dof_frictionloss[loop.dofs] + loop.added_friction[0]
    signals = _signals(model, joints, rate_hz)
    return Machine(
        joints, 1 / signals.period_s, compensated, Plant(mass, damping, stiffness, drive, sense),
        _owners(compiled, joints), signals,
        np.stack([loop.kp[0], loop.kd[0]], axis=1), weight, np.maximum(friction, 0.0),
        stated if limits is None else np.minimum(stated, limits),
        left_out,
    )  # fmt: skip


def _owners(model: mujoco.MjModel, joints: tuple[str, ...]) -> np.ndarray:
    """(m,) which of the joints is on the axis of each degree of freedom."""
    names = [model.joint(i).name for i in model.dof_jntid]
    # what an effect adds to a joint is named after it, behind a slash
    return np.array([joints.index(n if n in joints else n.rpartition("/")[0]) for n in names])


def _plant(model: mujoco.MjModel, loop, q: np.ndarray) -> tuple[np.ndarray, ...]:
    """Mass, damping, stiffness and the joints' weight at a pose."""
    data = mujoco.MjData(model)
    data.qpos[loop.qpos] = q
    mujoco.mj_forward(model, data)
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    springs = np.zeros(model.nv)
    springs[model.jnt_dofadr] = model.jnt_stiffness
    return mass, model.dof_damping.copy(), np.diag(springs), data.qfrc_bias[loop.dofs].copy()


def _leaning(loop, q: np.ndarray) -> np.ndarray:
    """(m, m) N·m/rad by which the weight pulls more as joints move."""
    model = loop.batch.model
    data, m = mujoco.MjData(model), model.nv
    found = np.zeros((m, m))

    def weight(qpos: np.ndarray) -> np.ndarray:
        data.qpos[:] = qpos
        mujoco.mj_forward(model, data)
        return data.qfrc_bias.copy()

    start = np.zeros(model.nq)
    start[loop.qpos] = q
    rest = weight(start)
    for dof in range(m):
        moved = start.copy()
        moved[model.jnt_qposadr[model.dof_jntid[dof]]] += STEP_RAD
        found[:, dof] = (weight(moved) - rest) / STEP_RAD
    return found


def _signals(model: Model, joints: tuple[str, ...], rate_hz: float) -> Signals:
    def value(effect: str, key: str, without: float) -> np.ndarray:
        return _value(model, effect, key, joints, without)

    slow = value("low_rate_loop", "rate", np.inf)[0]
    torque, measured = (value(f"{what}_delay", "delay", 0.0) for what in ("torque", "measurement"))
    return Signals(
        1 / min(rate_hz, slow),
        torque + measured,
        value("command_delay", "delay", 0.0) - measured,
        value("velocity_filter", "cutoff", np.inf),
        value("actuator_bandwidth", "cutoff", np.inf),
    )


def _value(
    model: Model, effect: str, key: str, joints: tuple[str, ...], without: float
) -> np.ndarray:
    """(n,) of a parameter, with what stands for it where the model lacks it."""
    found = model.effects.get(effect, {}).get(key, without)
    if not isinstance(found, (int, float)):
        return np.array([found.get(joint, without) for joint in joints], float)
    return np.full(len(joints), float(found))


def _left_out(model: Model, joints: tuple[str, ...]) -> tuple[str, ...]:
    known = model.known_effects(joints)
    names = [name for name in model.effects if name not in LINEAR]
    return (*(known[name].title for name in names), *["a learned curve"] * len(model.learned))
