"""A control loop that is led along a given motion: what torque it puts on the joints there.

Effects install themselves as in a simulation (`t2l.sim.servo`), but nothing moves by itself: at
every tick the loop is shown a position and a velocity and asked for the torque. Two variants of a
plant differ along a motion by the difference of their torques, less what their inverse dynamics
differ by. To first order that is what one of them lacks against the other.

What remembers nothing needs no order of ticks, so that all of them are one call (`all_at_once`).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from t2l.sim.arrays import columns
from t2l.sim.loop import Loop
from t2l.sim.poses import Poses
from t2l.sim.regressor import inertial_parameters
from t2l.sim.schedule import Drive, Schedule
from t2l.sim.servo import commands, feed_forward

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
        half = 0.5 * self.period_s
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
            middle_q, middle_dq = q + half * dq, dq + half * every(path.ddq[tick])
            if rubs:
                level = dry.copy()
                for add in self.friction:
                    add(tick, middle_dq, torque, level)
            if balanced is not None:
                # the balance that the model has goes by itself
                torque -= weight
            for add in self.joint_torques:
                add(tick, middle_q, middle_dq, torque)
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

    def by_bodies(self, poses: Poses) -> np.ndarray | None:
        """N·m that the masses of bodies, gravity and what encoders are off take in each variant.

        (npose, nvariant, nrec, njoint), beyond the model; None if all variants have the same.
        """
        changed = self.batch.changed
        offset = self.encoder_offset.reshape(self.nvariant, self.nrec, -1)
        rows = slice(0, None, self.nrec)
        fields = [changed[name][rows] for name in OF_BODIES if name in changed] + [offset]
        if all((values == values[:1]).all() for values in fields):
            return None
        of_masses = [name for name in INERTIAL if name in changed]
        return poses.beyond(
            self.batch.model, self.dofs,
            self._other_masses(rows) if of_masses else None,
            changed["opt.gravity"][rows] if "opt.gravity" in changed else None,
            offset if offset.any() else None,
        )  # fmt: skip

    def _other_masses(self, rows: slice) -> np.ndarray:
        """Inertial parameters (nvariant, nbody, 10) beyond the model's."""
        model, changed = self.batch.model, self.batch.changed
        own = inertial_parameters(*(getattr(model, name) for name in (*INERTIAL, "body_iquat")))
        found = []
        for i in range(self.nvariant):
            values = (changed[n][rows][i] if n in changed else getattr(model, n) for n in INERTIAL)
            found.append(inertial_parameters(*values, model.body_iquat) - own)
        return np.array(found)

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
