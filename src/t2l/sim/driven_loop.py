"""A control loop that is led along a given motion: what torque it puts on the joints there.

Effects install themselves as in a simulation (`t2l.sim.servo`), but nothing moves by itself: at
every tick the loop is shown a position and a velocity and asked for the torque. Two variants of a
plant differ along a motion by the difference of their torques, less what their inverse dynamics
differ by. To first order that is what one of them lacks against the other.

What remembers nothing needs no order of ticks, so that all of them are one call (`all_at_once`).
"""

import copy
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import mujoco
import numpy as np
from scipy.ndimage import uniform_filter1d

from t2l.sim.arrays import columns
from t2l.sim.loop import Loop
from t2l.sim.regressor import PARAMETERS, inertial_parameters, regressor
from t2l.sim.schedule import Drive, Schedule
from t2l.sim.servo import commands, feed_forward

POSES_PER_S = 100.0  # numerics: at which inverse dynamics are evaluated, linear between them
# fields of a model that only its inverse dynamics know
INERTIAL = ("body_mass", "body_ipos", "body_inertia")
OF_BODIES = (*INERTIAL, "opt.gravity")

# what a motion has at every tick
PER_TICK = ("q", "dq", "ddq", "load", "weight", "taken")


@dataclass(frozen=True)
class Path:
    """A motion at the ticks of a schedule; (ntick, nrec, njoint) each.

    Attributes:
        q, dq, ddq: rad, rad/s and rad/s².
        load: N·m that the plant's weight and its velocity ask for, as MuJoCo's qfrc_bias.
        weight: N·m, of that the weight of the nominal model alone.
        at_rest: (njoint,) rad/s, below which the sign of a velocity is not known.
        taken: N·m that the plant takes on average from this tick to the next; None where it is not
            asked for what holds a joint at rest.
    """

    q: np.ndarray
    dq: np.ndarray
    ddq: np.ndarray
    load: np.ndarray
    weight: np.ndarray
    at_rest: np.ndarray
    taken: np.ndarray | None = None

    def of(self, recordings: np.ndarray) -> "Path":
        """Of some recordings, (k,) indices."""
        return self._each(lambda values: values[:, recordings])

    def all_at_once(self) -> "Path":
        """One tick, at which each tick of each recording is a recording."""
        return self._each(lambda values: values.reshape(1, -1, self.q.shape[2]))

    def _each(self, change: Callable[[np.ndarray], np.ndarray]) -> "Path":
        values = ((name, getattr(self, name)) for name in PER_TICK)
        return replace(self, **{name: change(v) for name, v in values if v is not None})


def all_at_once(schedule: Schedule, ntick: int) -> Schedule:
    """A schedule of one tick, at which each tick of each recording is a recording."""
    nrec, njoint = schedule.kp.shape

    def every(values):
        return np.tile(values, (ntick, *(1,) * (values.ndim - 1)))

    def flat(values):
        return None if values is None else values[:ntick].reshape(1, ntick * nrec, njoint)

    drive = schedule.drive
    clock = np.zeros(nrec) if schedule.clock_s is None else schedule.clock_s
    passed = np.arange(ntick) * schedule.period_s
    return replace(
        schedule,
        commands=flat(schedule.commands),
        dq_des=flat(schedule.dq_des),
        tau_ff=flat(schedule.tau_ff),
        kp=every(schedule.kp),
        kd=every(schedule.kd),
        start_q=every(schedule.start_q),
        start_dq=every(schedule.start_dq),
        compensated=every(schedule.compensated),
        balanced=every(schedule.balanced),
        powered=flat(schedule.powered),
        clock_s=(passed[:, None] + clock).ravel(),
        elapsed_s=np.repeat(passed, nrec),
        command_period_s=None
        if schedule.command_period_s is None
        else every(schedule.command_period_s),
        logged={name: flat(values) for name, values in schedule.logged.items()},
        hold=None if schedule.hold is None else schedule.hold.each(flat),
        drive=None
        if drive is None
        else Drive(every(drive.stall), every(drive.back_emf), flat(drive.supply)),
    )


class _Fields:
    """Stands for a batch: fields of the model for each simulation, and the state it is shown."""

    def __init__(self, model: mujoco.MjModel, nsim: int):
        self.model, self.nsim = model, nsim
        self.qpos = np.zeros((nsim, model.nq))
        self.qvel = np.zeros((nsim, model.nv))
        self.qfrc_applied = np.zeros((nsim, model.nv))
        self.changed: dict[str, np.ndarray] = {}
        self.bound: dict[str, np.ndarray] = {}

    def expand(self, name: str) -> np.ndarray:
        if name not in self.changed:
            value = np.asarray(_field(self.model, name), float)
            self.changed[name] = np.tile(value, (self.nsim, *(1,) * value.ndim))
        return self.changed[name]

    def expanded(self, name: str) -> np.ndarray | None:
        return self.changed.get(name)

    def bind(self, name: str) -> np.ndarray:
        if name not in self.bound:
            self.bound[name] = np.zeros((self.nsim, self.model.nv))
        return self.bound[name]

    def forward(self) -> None:
        """Nothing: the state is given."""

    set_const = forward


def _field(model: mujoco.MjModel, name: str):
    value = model
    for part in name.split("."):
        value = getattr(value, part)
    return value


class DrivenLoop(Loop):
    """A loop that is led along a motion of each recording."""

    def __init__(
        self, model: mujoco.MjModel, joints: tuple[str, ...], schedule: Schedule, nvariant: int
    ):
        super().__init__(model, joints, schedule, nvariant)
        self.batch = _Fields(model, self.nrec * nvariant)

    def torque(self, path: Path, bodies: np.ndarray | None = None) -> np.ndarray:
        """N·m on the joints along a motion, (ntick, nvariant, nrec, njoint).

        All that acts is in it: motor, friction, springs, dampers and the armature. Dry friction
        holds a joint at rest with what it needs, up to its level.

        Args:
            bodies: N·m likewise, that other masses or another gravity add, see `by_bodies`.
        """
        ntick, many = len(path.q), self.nvariant
        out = np.empty((ntick, *self.kp.shape))
        schedule, batch = self.schedule, self.batch
        recording = np.tile(np.arange(self.nrec), many)

        def every(values: np.ndarray) -> np.ndarray:
            """A copy (nsim, njoint) of what all variants share, (nrec, njoint)."""
            return values.take(recording, axis=0)

        factor = self.compensation_factor
        compensated, balanced = (
            every(on)[:, None] if on.any() else None
            for on in (schedule.compensated, schedule.balanced)
        )
        damping = self.kd + self.ahead * self.kp
        heavier = self.added_armature() + self.ahead * self.kd
        limited = np.isfinite(self.motor_limits).any()
        dry, rubs = self._dry(), self.rubs
        least, most = (np.full_like(self.kp, limit) for limit in self.motor_limits.T)
        command, added = commands(schedule.commands, self), feed_forward(self)
        at_rest, back_emf = path.at_rest, None
        if schedule.drive is not None:
            back_emf = every(schedule.drive.back_emf)
        qpos, dofs = columns(self.qpos), columns(self.dofs)
        shown = {"qfrc_bias": path.load, "qfrc_gravcomp": path.weight}
        for tick in range(ntick):
            measured, dq = every(path.q[tick]), every(path.dq[tick])
            q, measured_dq = measured - self.encoder_offset, dq.copy()
            batch.qpos[:, qpos], batch.qvel[:, dofs] = q, dq
            for name, values in shown.items():
                if name in batch.bound:
                    batch.bound[name][:, dofs] = every(values[tick])
            if "qfrc_passive" in batch.bound:
                batch.bound["qfrc_passive"][:, dofs] = self._own_passive(q, dq)
            for change in self.sensor_filters:
                change(tick, measured, measured_dq)
            if schedule.hold is not None:
                pull = schedule.hold.torque(tick, measured, measured_dq)
            for change in self.feedback_filters:
                change(tick, measured, measured_dq)
            target = command(tick)
            for change in self.command_filters:
                change(tick, target)
            torque = self.kp * (target - measured) - damping * measured_dq
            if added is not None:
                torque += added(tick)
            if compensated is not None:
                torque += compensated * factor * every(path.weight[tick])
            for change in self.controller_filters:
                change(tick, torque)
            if schedule.drive is not None:
                schedule.drive.give(tick, torque)
            carried = 0.0
            if balanced is not None:
                weight = balanced * every(path.weight[tick])
                carried = weight * factor
                torque += carried
            for change in self.motor_filters:
                change(tick, torque)
            if limited:
                np.minimum(np.maximum(torque, least, out=torque), most, out=torque)
            if schedule.powered is not None:
                on = schedule.powered[tick][recording]
                torque = carried + (torque - carried) * on
            if rubs:
                level = dry.copy()
                for add in self.friction:
                    add(tick, dq, torque, level)
            if balanced is not None:
                # the balance that the model has goes by itself
                torque -= weight
            for add in self.joint_torques:
                add(tick, q, dq, torque)
            torque += self._passive(q, dq)
            if back_emf is not None:
                on = 1.0 if schedule.powered is None else schedule.powered[tick][recording]
                torque -= back_emf * on * dq
            if schedule.hold is not None:
                torque += pull
            torque -= heavier * every(path.ddq[tick])
            if bodies is not None:
                torque += bodies[tick].reshape(torque.shape)
            if rubs:
                excess = 0.0 if path.taken is None else torque - every(path.taken[tick])
                torque -= _dry_friction(level, dq, at_rest, excess)
            out[tick] = torque
        return out.reshape(ntick, many, self.nrec, -1)

    def _dry(self) -> np.ndarray:
        """N·m (nsim, njoint) of constant friction."""
        own = self.batch.changed.get("dof_frictionloss", self.batch.model.dof_frictionloss)
        return self.added_friction + own[..., self.dofs]

    @property
    def rubs(self) -> bool:
        """Whether a joint has dry friction."""
        return bool(self.friction) or bool(self._dry().any())

    def by_bodies(self, poses: "Poses") -> np.ndarray | None:
        """N·m that the masses of bodies and gravity take in each variant, but for what all share.

        (npose, nvariant, nrec, njoint); None if all variants have the same.
        """
        batch = self.batch
        fields = {name: batch.changed[name] for name in OF_BODIES if name in batch.changed}
        if not fields and not self.encoder_offset.any():
            return None
        rows = range(0, self.nrec * self.nvariant, self.nrec)
        offsets = [self.encoder_offset[row : row + self.nrec] for row in rows]
        each = [{name: values[row] for name, values in fields.items()} for row in rows]
        asked = [
            b"".join(values.tobytes() for values in (offset, *own.values()))
            for offset, own in zip(offsets, each, strict=True)
        ]
        if len(set(asked)) == 1:
            return None
        if not self.encoder_offset.any() and not (fields.keys() - INERTIAL):
            return self._by_inertia(poses, fields)
        distinct = dict(zip(asked, zip(each, offsets, strict=True), strict=True))
        known = {
            key: poses.inverse(batch.model, own, self.dofs, self.qpos, offset)
            for key, (own, offset) in distinct.items()
        }
        return np.stack([known[key] for key in asked], axis=1)

    def _by_inertia(self, poses: "Poses", fields: Mapping[str, np.ndarray]) -> np.ndarray:
        """The same beyond what the model takes, if only the masses of bodies are others."""
        model = self.batch.model
        own = inertial_parameters(*(getattr(model, name) for name in (*INERTIAL, "body_iquat")))
        change = []
        for row in range(0, self.nrec * self.nvariant, self.nrec):
            values = (fields[n][row] if n in fields else getattr(model, n) for n in INERTIAL)
            change.append(inertial_parameters(*values, model.body_iquat) - own)
        y = poses.regressor(model, self.dofs, self.qpos)
        return np.einsum("prbnk,vbk->pvrn", y, np.array(change), optimize=True)

    def changes_only_bodies(self) -> bool:
        """Whether effects changed nothing of it but the masses of bodies and gravity."""
        fresh = Loop(self.batch.model, self.joints, self.schedule, self.nvariant)
        own = {k: v for k, v in vars(fresh).items() if isinstance(v, np.ndarray | list)}
        own.pop("other_weight")  # which no torque of the loop asks for
        same = all(np.array_equal(getattr(self, name), value) for name, value in own.items())
        return same and not self.batch.bound and set(self.batch.changed) <= set(OF_BODIES)

    def added_armature(self) -> np.ndarray:
        """kg·m² beyond the model's, (nsim, njoint)."""
        changed = self.batch.changed.get("dof_armature")
        if changed is None:
            return np.zeros_like(self.kp)
        return changed[:, self.dofs] - self.batch.model.dof_armature[self.dofs]

    def _own_passive(self, q: np.ndarray, dq: np.ndarray) -> np.ndarray:
        model = self.batch.model
        spring = model.jnt_stiffness[self.ids] * (q - model.qpos_spring[self.qpos])
        return -spring - model.dof_damping[self.dofs] * dq

    def _passive(self, q: np.ndarray, dq: np.ndarray) -> np.ndarray | float:
        """N·m of springs and dampers beyond those that the model has."""
        model, changed, torque = self.batch.model, self.batch.changed, 0.0
        if "dof_damping" in changed:
            more = changed["dof_damping"][:, self.dofs] - model.dof_damping[self.dofs]
            torque = torque - more * dq
        if "dof_dampingpoly" in changed:
            more = changed["dof_dampingpoly"][:, self.dofs] - model.dof_dampingpoly[self.dofs]
            torque = torque - (more[..., 0] * np.abs(dq) + more[..., 1] * dq**2) * dq
        if "jnt_stiffness" in changed or "qpos_spring" in changed:
            own = model.jnt_stiffness[self.ids], model.qpos_spring[self.qpos]
            springs = changed.get("jnt_stiffness"), changed.get("qpos_spring")
            k = own[0] if springs[0] is None else springs[0][:, self.ids]
            rest = own[1] if springs[1] is None else springs[1][:, self.qpos]
            torque = torque - k * (q - rest) + own[0] * (q - own[1])
        return torque


def _dry_friction(
    level: np.ndarray, dq: np.ndarray, at_rest: np.ndarray, excess: np.ndarray
) -> np.ndarray:
    """N·m against the motion: `level` in motion, and at rest what holds against `excess`."""
    square = dq**2 + at_rest**2
    most = np.maximum(level, 0.0)
    held = np.minimum(np.maximum(excess, -most), most)
    return level * dq / np.sqrt(square) + held * (at_rest**2 / square)


class Poses:
    """Some of the places of a motion, and what rigid bodies ask for there.

    Attributes:
        q, dq, ddq: (npose, nrec, njoint).
    """

    def __init__(self, path: Path, period_s: float):
        ntick = len(path.q)
        every = max(1, round(1 / (POSES_PER_S * period_s)))
        self.at = np.unique(np.append(np.arange(0, ntick, every), ntick - 1))
        self.ntick = ntick
        # a command makes the acceleration jump: what is between two places counts too
        ddq = uniform_filter1d(path.ddq, every, axis=0, mode="nearest")
        self.q, self.dq, self.ddq = (values[self.at] for values in (path.q, path.dq, ddq))
        # by identity; the model is held, so that no other takes its place
        self._regressors: dict[int, tuple[mujoco.MjModel, np.ndarray]] = {}

    def at_ticks(self, values: np.ndarray) -> np.ndarray:
        """Values (npose, …) at every tick, (ntick, …), linear between the poses, as precise."""
        ticks = np.arange(self.ntick)
        after = np.clip(np.searchsorted(self.at, ticks, side="left"), 1, len(self.at) - 1)
        gap = self.at[after] - self.at[after - 1]
        part = ((ticks - self.at[after - 1]) / gap).reshape(-1, *(1,) * (values.ndim - 1))
        found = np.diff(values, axis=0)[after - 1]
        found *= part.astype(values.dtype)
        found += values[after - 1]
        return found

    def inverse(
        self,
        model: mujoco.MjModel,
        fields: Mapping[str, np.ndarray],
        dofs: np.ndarray,
        qpos: np.ndarray,
        offset: np.ndarray | float = 0.0,
    ) -> np.ndarray:
        """N·m that the motion takes of a model with other `fields`, (npose, nrec, njoint).

        Args:
            offset: rad, of the encoders, (nrec, njoint).
        """
        model = _bare(model)
        for name, value in fields.items():
            _field(model, name)[:] = value
        data = mujoco.MjData(model)
        if fields:
            mujoco.mj_setConst(model, data)
        out = np.empty(self.q.shape)
        where = self.q - offset
        for index in np.ndindex(self.q.shape[:2]):
            data.qpos[qpos], data.qvel[dofs] = where[index], self.dq[index]
            data.qacc[dofs] = self.ddq[index]
            mujoco.mj_inverse(model, data)
            out[index] = data.qfrc_inverse[dofs]
        return out

    def regressor(self, model: mujoco.MjModel, dofs: np.ndarray, qpos: np.ndarray) -> np.ndarray:
        """Y of `t2l.sim.regressor` along the motion, (npose, nrec, nbody, njoint, 10)."""
        if id(model) not in self._regressors:
            bare = _bare(model)
            data = mujoco.MjData(bare)
            shape = (*self.q.shape[:2], model.nbody, len(dofs), PARAMETERS)
            out = np.empty(shape)
            for index in np.ndindex(self.q.shape[:2]):
                data.qpos[qpos], data.qvel[dofs] = self.q[index], self.dq[index]
                data.qacc[dofs] = self.ddq[index]
                mujoco.mj_inverse(bare, data)
                out[index] = regressor(bare, data, dofs)
            self._regressors[id(model)] = model, out
        return self._regressors[id(model)][1]


def _bare(model: mujoco.MjModel) -> mujoco.MjModel:
    """A copy whose inverse dynamics are those of its bodies alone."""
    model = copy.copy(model)
    model.opt.disableflags |= (
        mujoco.mjtDisableBit.mjDSBL_CONSTRAINT | mujoco.mjtDisableBit.mjDSBL_SPRING
        | mujoco.mjtDisableBit.mjDSBL_DAMPER
    )  # fmt: skip
    model.body_gravcomp[:] = 0.0  # what cancels the weight is the controller's
    return model
