"""A control loop that is led along a given motion: what torque it puts on the joints there.

Effects install themselves as in a simulation (`t2l.sim.servo`), but nothing moves by itself: at
every tick the loop is shown a position and a velocity and asked for the torque. Two variants of a
plant differ along a motion by the difference of their torques, less what their inverse dynamics
differ by. To first order that is what one of them lacks against the other.

What remembers nothing needs no order of ticks, so that all of them are one call (`all_at_once`).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import groupby

import mujoco
import numpy as np

from t2l.sim.arrays import columns
from t2l.sim.commands import commands, feed_forward
from t2l.sim.loop import Loop, over_ticks
from t2l.sim.poses import Poses
from t2l.sim.regressor import inertial_parameters
from t2l.sim.schedule import Drive, Schedule

# fields of a model that only its inverse dynamics know
INERTIAL = ("body_mass", "body_ipos", "body_inertia")
OF_BODIES = (*INERTIAL, "opt.gravity")

# of a loop, what the torque of its motors depends on, and places where it is known
OF_MOTOR = (
    "kp", "kd", "ahead", "encoder_offset", "command_lead_s", "command_delay_s",
    "compensation_factor", "motor_limits",
)  # fmt: skip
AFTER_MOTOR = ("friction", "joint_torques")

BEGINS_S = 0.01  # numerics: of a motion, what it takes at the start is the mean of
# numerics: ticks that are computed at once, more of a small batch: arrays that a cache holds
BLOCK, CACHED = 64, 32_000
# what a motion has at every tick
PER_TICK = ("q", "dq", "ddq", "load", "weight", "taken", "link")


@dataclass(frozen=True)
class Path:
    """A motion at the ticks of a schedule; (ntick, nrec, njoint) each.

    Attributes:
        q, dq, ddq: rad, rad/s and rad/s².
        load: N·m that the plant's weight and its velocity ask for, as MuJoCo's qfrc_bias.
        weight: N·m, of that the weight of the nominal model alone.
        at_rest: (njoint,) rad/s, below which the sign of a velocity is not known.
        taken: N·m that the plant takes on average from this tick to the next.
        holds: whether dry friction is asked for what holds a joint at rest.
        link: N·m likewise that links take without rotors; None where nothing gives between them.
    """

    q: np.ndarray
    dq: np.ndarray
    ddq: np.ndarray
    load: np.ndarray
    weight: np.ndarray
    at_rest: np.ndarray
    taken: np.ndarray | None = None
    link: np.ndarray | None = None
    holds: bool = True

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
        moving=None if schedule.moving is None else every(schedule.moving),
        clock_s=(passed[:, None] + clock).ravel(),
        elapsed_s=np.repeat(passed, nrec),
        command_period_s=None
        if schedule.command_period_s is None
        else every(schedule.command_period_s),
        logged={name: flat(values) for name, values in schedule.logged.items()},
        stamped_of=None if schedule.stamped_of is None else every(schedule.stamped_of),
        phase=None if schedule.phase is None else every(schedule.phase),
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
    """A loop that is led along a motion of each recording.

    Attributes:
        path: the motion; whoever asks for a torque gives it.
    """

    path: Path

    def __init__(
        self, model: mujoco.MjModel, joints: tuple[str, ...], schedule: Schedule, nvariant: int
    ):
        super().__init__(model, joints, schedule, nvariant)
        self.batch = _Fields(model, self.nrec * nvariant)
        self.at = columns(self.qpos), columns(self.dofs)

    def torque(
        self, path: Path, bodies: np.ndarray | None = None, motor: np.ndarray | None = None
    ) -> np.ndarray:
        """N·m on the joints along a motion, (ntick, nvariant, nrec, njoint).

        All that acts is in it: motor, friction, springs, dampers and the armature. Dry friction
        holds a joint at rest with what it needs, up to its level.

        Args:
            bodies: N·m likewise, that other masses or another gravity add, see `by_bodies`.
            motor: N·m (ntick, nrec, njoint) of the motor, see `motor_torque`, where it is known.
        """

        def each(ticks: range, target, added) -> np.ndarray:
            some, state = slice(ticks.start, ticks.stop), self._state(path, ticks)
            if motor is None:
                reached, pull = self._motor(path, ticks, state, target, added)
            else:
                reached, pull = self._every(motor[some]), None
            moved = None if bodies is None else bodies[some]
            return self._joint(path, ticks, state, reached, pull, moved)

        return self._along(path, each)

    def motor_torque(self, path: Path) -> np.ndarray:
        """N·m that the motors put on the joints, (ntick, nvariant, nrec, njoint)."""

        def each(ticks: range, target, added) -> np.ndarray:
            return self._motor(path, ticks, self._state(path, ticks), target, added)[0]

        return self._along(path, each)

    def _along(self, path: Path, each: Callable) -> np.ndarray:
        self.path, ntick = path, len(path.q)
        out = np.empty((ntick, *self.kp.shape))
        target, added = commands("commands", self, smooth=True), feed_forward(self, smooth=True)
        if path.taken is not None:
            begins = path.taken[: 1 + round(BEGINS_S / self.period_s)].mean(axis=0)
            self.taken = begins[self.recording]
        at_once = 1 if self.in_order else max(BLOCK, CACHED // self.kp.size)
        for begin in range(0, ntick, at_once):
            ticks = range(begin, min(begin + at_once, ntick))
            out[ticks.start : ticks.stop] = each(ticks, target, added)
        return out.reshape(ntick, self.nvariant, self.nrec, -1)

    def _state(self, path: Path, ticks: range) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Where the joints truly are, how fast, and how fast halfway to the next tick.

        Each (k, nsim, njoint), rad and rad/s.
        """
        some, half = slice(ticks.start, ticks.stop), 0.5 * self.period_s
        q, dq, ddq = (self._every(values[some]) for values in (path.q, path.dq, path.ddq))
        return q - self.encoder_offset, dq, dq + half * ddq

    def _call(
        self,
        callbacks: list[Callable],
        path: Path,
        ticks: range,
        state: tuple[np.ndarray, ...],
        *signals: np.ndarray,
        reaching: Sequence[np.ndarray] = (),
    ) -> None:
        """Call what acts at one place for all ticks, each (k, nsim, njoint)."""
        for at_once, alike in groupby(callbacks, lambda change: hasattr(change, "over_ticks")):
            if at_once:
                self._show(path, ticks.start, state, 0, reaching)
                for change in alike:
                    change(np.arange(ticks.start, ticks.stop), *signals)
                continue
            alike = list(alike)
            for i, tick in enumerate(ticks):
                now = [values[i] for values in state]
                self._show(path, tick, now, ..., [one[i] for one in reaching])
                for change in alike:
                    change(tick, *(signal[i] for signal in signals))

    def _motor(
        self, path: Path, ticks: range, state: tuple[np.ndarray, ...], target, added
    ) -> tuple[np.ndarray, np.ndarray | None]:
        """Of the motor at some ticks that follow each other, (k, nsim, njoint), and of a hold.

        What acts at one place is called for all of them, before what acts at the next.
        """
        some, schedule = slice(ticks.start, ticks.stop), self.schedule
        measured, measured_dq = self._every(path.q[some]), self._every(path.dq[some])
        self._call(self.sensor_filters, path, ticks, state, measured, measured_dq)
        pull = None
        if schedule.hold is not None:
            pairs = zip(ticks, measured, measured_dq, strict=True)
            pull = np.stack([schedule.hold.torque(*one) for one in pairs])
        self._call(self.feedback_filters, path, ticks, state, measured, measured_dq)
        # one by one they are looked up for some at once
        one = len(ticks) == 1
        wanted = target(ticks.start)[None] if one else target(np.arange(ticks.start, ticks.stop))
        self._call(self.command_filters, path, ticks, state, wanted)
        torque = self.kp * (wanted - measured)
        torque -= (self.kd + self.ahead * self.kp) * measured_dq
        if added is not None:
            torque += np.stack([added(tick) for tick in ticks])
        weight = self._every(path.weight[some])
        if schedule.compensated.any():
            on = self._every(schedule.compensated[:, None])
            torque += on * self.compensation_factor * weight
        reaching = wanted, measured, measured_dq
        self._call(self.controller_filters, path, ticks, state, torque, reaching=reaching)
        if schedule.drive is not None:
            for tick, one in zip(ticks, torque, strict=True):
                schedule.drive.give(tick, one)
        carried = 0.0
        if schedule.balanced.any():
            weight = weight * self._every(schedule.balanced[:, None])
            carried = weight * self.compensation_factor
            torque += carried
        self._call(self.motor_filters, path, ticks, state, torque)
        if np.isfinite(self.motor_limits).any():
            np.clip(torque, *self.motor_limits.T, out=torque)
        if schedule.powered is not None:
            torque = carried + (torque - carried) * self._every(schedule.powered[some])
        return torque, pull

    def _joint(
        self,
        path: Path,
        ticks: range,
        state: tuple[np.ndarray, ...],
        torque: np.ndarray,
        pull: np.ndarray | None,
        bodies: np.ndarray | None,
    ) -> np.ndarray:
        """On the joints, (k, nsim, njoint), where motors give `torque`."""
        some, k = slice(ticks.start, ticks.stop), len(ticks)
        schedule, half = self.schedule, 0.5 * self.period_s
        (q, dq, middle_dq), ddq = state, self._every(path.ddq[some])
        middle_q = q + half * dq
        level = self._dry()
        if self.friction:
            level = np.tile(level, (k, 1, 1))
            self._call(self.friction, path, ticks, state, middle_dq, torque, level)
        if schedule.balanced.any():
            # the balance that the model has goes by itself
            torque -= self._every(path.weight[some]) * self._every(schedule.balanced[:, None])
        self._call(self.joint_torques, path, ticks, state, middle_q, middle_dq, torque)
        torque += self._passive(middle_q, middle_dq)
        if schedule.drive is not None:
            on = 1.0 if schedule.powered is None else self._every(schedule.powered[some])
            torque -= self._every(schedule.drive.back_emf) * on * middle_dq
        if pull is not None:
            torque += pull
        torque -= (self.added_armature() + self.ahead * self.kd) * ddq
        if bodies is not None:
            torque += bodies.reshape(torque.shape)
        if self.rubs:
            asked = path.holds and path.taken is not None
            excess = torque - self._every(path.taken[some]) if asked else 0.0
            torque -= _dry_friction(level, dq, 2 * middle_dq - dq, path.at_rest, excess)
        return torque

    def in_motion(self, rows: slice, joints: np.ndarray, law: Callable) -> Callable:
        """As of `ServoLoop`, where the velocity is known."""
        at = ..., rows, self.columns(joints)

        @over_ticks
        def change(tick, torque: np.ndarray) -> None:
            torque[at] = law(tick, torque[at], self.middle_dq[at])

        return change

    def springs(self, rows: slice, joints: np.ndarray) -> Callable:
        """As `ServoLoop.springs`, also of several ticks: the mean torque until the next tick."""
        at, half = (..., rows, self.columns(joints)), 0.5 * self.period_s

        def give(torque: np.ndarray, stiffness: np.ndarray, damping: np.ndarray) -> None:
            torque[at] -= (half * stiffness + damping) * self.middle_dq[at]

        return give

    def loads(self) -> Callable:
        """As of `Loop`, along the motion that is led."""
        return lambda tick: self._every(self.path.load[tick])

    def until_next(self) -> Callable:
        """As of `ServoLoop`, where a force is that of the middle of the tick already."""
        return lambda tick, now: now

    def _every(self, values: np.ndarray) -> np.ndarray:
        """A copy (…, nsim, k) of what all variants share, (…, nrec, k)."""
        return values.take(self.recording, axis=-2)

    def _show(self, path: Path, tick: int, state: Sequence[np.ndarray], first, reaching) -> None:
        """Let loop and batch be where the motion is at a tick, or the loop at several.

        Args:
            state: of `_state`, (nsim, njoint) or (k, nsim, njoint); at `first` of these, the batch.
            reaching: likewise `Loop.command`, `measured` and `measured_dq`, where they are asked.
        """
        self.q, self.dq, self.middle_dq = state
        q, dq, _ = state
        if reaching:
            self.command, self.measured, self.measured_dq = reaching
        batch, (qpos, dofs) = self.batch, self.at
        q, dq = q[first], dq[first]
        batch.qpos[:, qpos], batch.qvel[:, dofs] = q, dq
        for name, values in (("qfrc_bias", path.load), ("qfrc_gravcomp", path.weight)):
            if name in batch.bound:
                batch.bound[name][:, dofs] = self._every(values[tick])
        if "qfrc_passive" in batch.bound:
            # as MuJoCo's: what balances the weight by itself is in it
            balance = path.weight[tick] * self.schedule.balanced[:, None]
            batch.bound["qfrc_passive"][:, dofs] = self._own_passive(q, dq) + self._every(balance)

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

    def acts_after_motor(self) -> bool:
        """Whether effects changed nothing that the torque of the motors depends on."""
        fresh = Loop(self.batch.model, self.joints, self.schedule, self.nvariant)
        alike = all(np.array_equal(getattr(self, n), getattr(fresh, n)) for n in OF_MOTOR)
        places = (calls for name, calls in self.places.items() if name not in AFTER_MOTOR)
        return alike and not any(places) and not self.feed_forward_filters and not self.in_order

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
    level: np.ndarray,
    dq: np.ndarray,
    next_dq: np.ndarray,
    at_rest: np.ndarray,
    excess: np.ndarray,
) -> np.ndarray:
    """N·m against the motion, on average over a tick.

    That is `level` while a joint goes one way, and what holds against `excess` while it rests. In a
    tick in which it turns or stops it is what the motion takes, too, as between both.

    Args:
        dq, next_dq: rad/s at this tick and at the next.
    """
    most = np.maximum(level, 0.0)
    held = np.minimum(np.maximum(excess, -most), most)
    slowest = np.where(dq * next_dq > 0, np.minimum(np.abs(dq), np.abs(next_dq)), 0.0)
    moves = slowest**2 / (slowest**2 + at_rest**2)
    return held + moves * (level * np.sign(dq) - held)
