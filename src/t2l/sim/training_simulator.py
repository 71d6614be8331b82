"""The training simulator: position actuators with six parameters each, at coarse timesteps.

The study's simulator has, per actuator, stiffness, damping, armature and a joint friction of
three numbers: static friction, its ratio to dynamic friction, and viscous friction. A joint at
rest is held by up to the static friction; one that moves feels the dynamic friction and the
viscous one.
"""

from collections.abc import Mapping, Sequence

import mujoco
import numpy as np

from t2l.sim.arrays import Array, columns, like, namespace
from t2l.sim.batch import MUJOCO, apply_position_gains, make_batch

Parameters = Mapping[str, np.ndarray]  # by name, (n, njoint) each

AT_REST_RAD_S = 1e-3  # numerics: slower joints feel static friction


class Simulator:
    """`n` robots in one batch, each with parameters of its own, alone or among other things.

    Args:
        spec: of a scene in which each of `joints` has an actuator of its name; what else moves in
            it is left to its own physics.
        torque_limit: (njoint,) N·m.
        device: of the simulations, see `t2l.sim.batch.make_batch`.

    Attributes:
        batch: the simulations.
        timestep_s: of the physics.
    """

    def __init__(
        self,
        spec: mujoco.MjSpec,
        joints: Sequence[str],
        torque_limit: np.ndarray,
        n: int,
        rate_hz: float,
        threads: int = 1,
        device: str = MUJOCO,
    ):
        self.joints, self.n, self.timestep_s = tuple(joints), n, 1.0 / rate_hz
        spec.option.timestep = self.timestep_s
        model = spec.compile()
        self.batch = make_batch(model, n, threads, device)
        # bound once: these are views that follow the batch
        self._qpos, self._qvel, self._ctrl = self.batch.qpos, self.batch.qvel, self.batch.ctrl
        named = [model.joint(name) for name in self.joints]
        self._q = columns(np.array([joint.qposadr[0] for joint in named]))
        self._dofs = columns(np.array([joint.dofadr[0] for joint in named]))
        self._actuators = columns(np.array([model.actuator(name).id for name in self.joints]))
        self._armature = self.batch.expand("dof_armature")
        self._damping = self.batch.expand("dof_damping")
        self._friction = self.batch.expand("dof_frictionloss")
        self._torque_limit = like(torque_limit, self._qpos)
        none = like(np.zeros((n, len(self.joints))), self._qpos)
        self._static = self._dynamic = none
        self._stiffness = self._kd = none + 1.0

    @property
    def q(self) -> Array:
        """(n, njoint) rad, of `joints`; a view where they are consecutive."""
        return self._qpos[:, self._q]

    @property
    def dq(self) -> Array:
        """(n, njoint) rad/s."""
        return self._qvel[:, self._dofs]

    def begin(self, ids: np.ndarray, qpos: Array) -> None:
        """Put simulations `ids` (k,) at rest at qpos (k, nq)."""
        self.batch.reset(ids=ids, stage=mujoco.mjtStage.mjSTAGE_NONE.value)
        if isinstance(self._qpos, np.ndarray):
            self.batch.warning[ids] = 0
        self._qpos[ids] = qpos

    def put(self, q: Array) -> None:
        """Put the joints of every robot at q, which broadcasts to (n, njoint) rad."""
        self._qpos[:, self._q] = q

    def set_parameters(self, parameters: Parameters) -> None:
        """Take parameters as identification names them, each broadcasting to (n, njoint)."""
        shape = tuple(self._static.shape)
        p = {k: like(np.broadcast_to(v, shape).copy(), self._qpos) for k, v in parameters.items()}
        self._stiffness, self._kd = p["stiffness"], p["damping"]
        apply_position_gains(self.batch, self.joints, self._stiffness, self._kd)
        self._armature[:, self._dofs] = p["armature"]
        self._damping[:, self._dofs] = p["viscous_friction"]
        self._static = p["static_friction"]
        self._dynamic = self._static * p["dynamic_friction_ratio"]
        self.batch.set_const()

    def step(self, q_des: Array, nstep: int) -> None:
        """Hold commands q_des (n, njoint) rad for `nstep` timesteps."""
        xp = namespace(self._qpos)
        for _ in range(nstep):
            q, dq = self.q, self.dq
            self._ctrl[:, self._actuators] = self._within_torque_limits(q_des, q, dq)
            moving = xp.abs(dq) > AT_REST_RAD_S
            self._friction[:, self._dofs] = xp.where(moving, self._dynamic, self._static)
            self.batch.step()

    def _within_torque_limits(self, q_des: Array, q: Array, dq: Array) -> Array:
        """Commands that ask for no more than the torque limits at the beginning of a timestep.

        A force limit on the actuators would not do: MuJoCo steps a saturated actuator explicitly,
        and at 100 Hz that throws light, damped joints about.
        """
        damping = self._kd * dq
        torque = self._stiffness * (q_des - q) - damping
        xp, limit = namespace(torque), self._torque_limit
        within = q + (xp.clip(torque, -limit, limit) + damping) / self._stiffness
        return xp.where(xp.abs(torque) <= limit, q_des, within)

    def simulate(
        self, q_des: np.ndarray, start_q: np.ndarray, start_dq: np.ndarray, nstep: int
    ) -> tuple[np.ndarray, np.ndarray]:
        """Positions and velocities (n, ncommand, njoint) at the instants commands are given.

        Args:
            q_des: (ncommand, njoint) or (ncommand, n, njoint) rad, each held for `nstep` timesteps.
            start_q, start_dq: broadcasting to (n, njoint).
        """
        self.batch.reset()
        self.put(start_q)
        self._qvel[:, self._dofs] = start_dq
        shape = (len(q_des), *self._static.shape)
        q, dq = np.empty(shape), np.empty(shape)
        for i, command in enumerate(q_des):
            q[i], dq[i] = self.q, self.dq
            if i + 1 < len(q_des):
                self.step(command, nstep)
        return q.transpose(1, 0, 2), dq.transpose(1, 0, 2)
