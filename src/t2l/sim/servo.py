"""Position-controlled joints as a robot runs them: torque held between the ticks of its loop.

    τ_k = Kp (q_des − q_k) + Kd (dq_des − q̇_k) + τ_ff + g(q_k),   held for one period

with velocity and torque where they are commanded too, and the gravity compensation g where the loop
gives one. A machine that compensates elsewhere, by springs or by a much faster loop of its drives,
does so continuously.

The plant moves under finer or equal physics steps of dt, of second order (`t2l.sim.steps`): under a
held torque a double integrator is exact. A loop of 1 kHz on a small stiff arm is then off by 0.01
mrad, and by 0.3 mrad otherwise. Velocities too are moved by a dt/2 meanwhile, so that Coriolis and
centrifugal forces are those of the middle of a step, and dampers are taken there (Crank and
Nicolson, 1947). One physics step a millisecond is then as near as eight without, on steps of a
SCARA.

A torque held for a period h is late by h/2 on average. A loop of n periods a tick therefore looks
ahead by the s = (n − 1) h/2 that it is later than the real one, to first order in s:

    Kp (q_des − q − s q̇) − Kd (q̇ + s q̈),

which is a damping of Kd + s Kp and an armature of s Kd more. On the motions of a real arm a tick of
4 ms instead of 1 ms is then off by 0.06 mrad, and by 0.8 mrad without.

What acts between controller and joint, as friction and the limits of a motor, does so continuously.
It is computed at every tick, and of a slow loop at plant ticks between these, while the torque that
the controller asks for is held.

A motor under a voltage (`t2l.recordings.motor`) gives no more than its stall torque, and its
back-EMF damps the joint continuously. Where no position is commanded, a `t2l.sim.schedule.Hold`
keeps the simulation near the measurement.
"""

import copy
from collections.abc import Callable, Iterator
from functools import cached_property

import mujoco
import numpy as np

from t2l.sim.arrays import columns
from t2l.sim.batch import diverged, make_batch
from t2l.sim.commands import WHOLE, commands, feed_forward
from t2l.sim.dry_friction import AddedFriction, stiffen
from t2l.sim.gravity import GravityCompensation
from t2l.sim.loop import Loop
from t2l.sim.schedule import Schedule
from t2l.sim.steps import Steps

MAX_TIMESTEP_S = 0.001
PLANT_PERIOD_S = 0.002  # numerics: at most, from plant tick to plant tick
LEAST_STIFFNESS = 1e-12  # numerics: N·m/rad, in place of zero
# numerics: of a speed, that is left at the next tick where a motion surely goes on
KEPT = 0.25
# numerics: times as fine in physics and plant ticks where something gives, and periods that a tick
# may have then: with more, play that meets between two ticks is fitted wrong
EXTENDED = 2
_CHECK_EVERY = 64  # ticks between looks for diverged simulations


class ServoLoop(Loop):
    """A loop whose plant is simulated, all of it in one batch.

    Args:
        substeps: physics steps a plant tick are multiplied by this.
        plant_period_s: the longest from plant tick to plant tick, if that is less than usual.

    Attributes:
        nstep: physics steps a plant tick.
        running: (nsim,) bool, which simulations have not diverged so far.
        sampled_later_s: (nsim, njoint) s, by how much samples are later than their stamps: what is
            left of `command_lead_s` beyond whole ticks. Known when the loop has run.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        joints: tuple[str, ...],
        schedule: Schedule,
        nvariant: int,
        threads: int,
        substeps: int = 1,
        plant_period_s: float = np.inf,
    ):
        model = copy.copy(model)  # loops in other threads have a step of their own
        super().__init__(model, joints, schedule, nvariant)
        times, every = finer(model, joints), min(plant_period_s, PLANT_PERIOD_S)
        self.plant_ticks = int(np.ceil(times * self.real_period_s / every - 1e-9))
        each = self.real_period_s / self.plant_ticks
        self.nstep = int(np.ceil(times * each / MAX_TIMESTEP_S - 1e-9)) * substeps
        model.opt.timestep = self.plant_period_s / self.nstep
        stiffen(model, joints)
        self.batch = make_batch(model, self.nrec * nvariant, threads)
        self.sampled_later_s = np.zeros_like(self.kp)

    def run(self, progress: Callable[[float], None] = lambda part: None) -> tuple[np.ndarray, ...]:
        """Measured position and velocity, (nvariant, nrec, nsample, njoint); NaN if it diverges.

        `progress` is told which part is done."""
        wanted, taken = self.schedule.sample_ticks.tolist(), 0
        out_q, out_dq = np.empty((2, len(wanted), *self.kp.shape))
        for tick, (measured, measured_dq) in enumerate(self.ticks()):
            if wanted[taken] == tick:
                out_q[taken], out_dq[taken] = measured, measured_dq
                taken += 1
                if taken == len(wanted):
                    break
            # that of a tick is done when the next begins
            if tick % _CHECK_EVERY == 1:
                progress((tick - 1) / wanted[-1])
        self.running &= ~diverged(self.batch)
        out_q[:, ~self.running] = out_dq[:, ~self.running] = np.nan
        order = (len(wanted), self.nvariant, self.nrec, len(self.joints))
        return (
            out_q.reshape(order).transpose(1, 2, 0, 3),
            out_dq.reshape(order).transpose(1, 2, 0, 3),
        )

    def ticks(self) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """What encoders read at each tick, position and velocity (nsim, njoint).

        The command of a tick is looked up after that, so whoever goes through the ticks may write
        it into the schedule by then. `running` says which simulations have not diverged.
        """
        batch, schedule = self.batch, self.schedule
        dt = batch.model.opt.timestep
        balance = self._balance()
        # in full, as the limits: what NumPy spreads at every tick takes it twice as long
        compensated = np.tile(schedule.compensated, self.nvariant)[:, None]
        compensated = compensated * self.compensation_factor
        gravity = GravityCompensation(batch, self.joints) if compensated.any() else None
        carrying = None if balance is None else self._carrying(balance)
        kd = self._look_ahead()
        self._center_damping()
        if self.inertia_changed:
            batch.set_const()
        self._split_lead()
        self._start()
        qpos, qvel, applied = batch.qpos, batch.qvel, batch.qfrc_applied
        at_qpos, dofs = columns(self.qpos), columns(self.dofs)
        running, all_run = np.ones(batch.nsim, bool), True
        self.running = running
        limited = np.isfinite(self.motor_limits).any()
        least, most = (np.full_like(self.kp, limit) for limit in self.motor_limits.T)
        command = commands("commands", self)
        added = feed_forward(self)
        recording = self.recording
        if self.friction or self.added_friction.any():
            friction = AddedFriction(batch, self.joints)
            friction.write(self.added_friction)
        last_dq, half = qvel[:, dofs].copy(), 0.5 * self.plant_period_s
        carried, hold, drive = 0.0, schedule.hold, schedule.drive
        brake = None if drive is None else self._brake()
        within = self.motor_filters or self.friction or self.joint_torques
        within = within or brake is not None or balance is not None
        parts = self.plant_ticks if within else 1
        nstep = self.nstep * (self.plant_ticks // parts)
        steps, faster = Steps(batch, at_qpos, dofs, nstep), self._faster(nstep * dt)
        damping = batch.expanded("dof_damping")
        damping = batch.model.dof_damping if damping is None else damping
        # masses are where the last step was halfway, and at the first tick where they start
        ahead = (0.5 * dt + self.ahead) / self.period_s
        later = (0.5 * dt + self.ahead) / (self.period_s - 0.5 * dt)
        for tick in range(schedule.sample_ticks[-1] + 1):
            q, dq = qpos[:, at_qpos].copy(), qvel[:, dofs].copy()
            measured, measured_dq = q + self.encoder_offset, dq
            if self.sensor_filters or self.feedback_filters:
                measured_dq = dq.copy()
                for change in self.sensor_filters:
                    change(tick, measured, measured_dq)
            yield measured, measured_dq
            if hold is not None:
                pull = hold.torque(tick, measured, measured_dq)
            for change in self.feedback_filters:
                change(tick, measured, measured_dq)
            target = command(tick)
            for change in self.command_filters:
                change(tick, target)
            demand = self.kp * (target - measured)
            demand -= kd * measured_dq
            if added is not None:
                demand += added(tick)
            if gravity:
                demand += compensated * gravity(later if tick == 1 else ahead)
            self.command, self.measured, self.measured_dq = target, measured, measured_dq
            for change in self.controller_filters:
                change(tick, demand)
            if drive is not None:
                drive.give(tick, demand)
            for part in range(parts):
                now = tick * self.plant_ticks + part
                if part:
                    q, dq = qpos[:, at_qpos].copy(), qvel[:, dofs].copy()
                middle_q, middle_dq = q + half * dq, 1.5 * dq - 0.5 * last_dq
                self.q, self.dq, self.middle_dq = q, dq, middle_dq
                torque = demand.copy()
                if balance is not None:
                    carried, balanced = carrying(now)
                    torque += carried
                for change in self.motor_filters:
                    change(now, torque)
                if limited:
                    np.minimum(np.maximum(torque, least, out=torque), most, out=torque)
                if schedule.powered is not None:
                    # what balances the weight elsewhere goes on
                    torque = carried + (torque - carried) * schedule.powered[tick][recording]
                if self.friction:
                    level = self.added_friction.copy()
                    for add in self.friction:
                        add(now, middle_dq, torque, level)
                    friction.write(level)
                if balance is not None:
                    # MuJoCo itself applies what carries the real weight
                    torque -= balanced
                if brake is not None:
                    torque -= brake(tick, dq)
                if hold is not None:
                    torque += pull
                for add in self.joint_torques:
                    add(now, middle_q, middle_dq, torque)
                more = faster(dq, torque)
                applied[:, dofs] = torque + damping[..., dofs] * more
                last_dq = dq
                failed = steps.go(None if all_run else running, more)
                if len(failed):
                    running[failed] = all_run = False
            if tick % _CHECK_EVERY == 0:
                running &= ~diverged(batch)
                all_run = running.all()
                qpos[~running] = np.nan
                qvel[~running] = 0.0

    def in_motion(self, rows: slice, joints: np.ndarray, law: Callable) -> Callable:
        """What changes torques as their velocity asks, called with (tick, torque), in place.

        The velocity is that halfway to the next plant tick: if the joint goes on as before, and
        what a joint alone has of the change of this torque since the last one. As a motor at its
        limit damps a joint strongly, that is solved for, by a secant.

        Args:
            law: called with (tick, torque, dq), all but the first (nrow, k): what becomes of it.
        """
        at = rows, self.columns(joints)
        further = 0.5 * self.plant_period_s / np.diag(self._mass)[at[1]]
        last: list[np.ndarray] = []

        def change(tick: int, torque: np.ndarray) -> None:
            asked, dq = torque[at], self.middle_dq[at]
            given = law(tick, asked, dq)
            # what it would give at rest, asked before the first tick, is none that it gave
            before = last.pop() if tick and last else given
            more = further * (given - before)
            steeper = law(tick, asked, dq + more) - given
            # law and joint agree where the secant meets the line of what the joint has
            slope = np.divide(steeper, more, out=np.zeros_like(more), where=more != 0)
            torque[at] = law(tick, asked, dq + more / (1 - np.minimum(further * slope, 0.0)))
            last[:] = [torque[at].copy()]

        return change

    def springs(self, rows: slice, joints: np.ndarray) -> Callable:
        """What gives joints a spring and a damper more until the next plant tick.

        Called with (torque, stiffness, damping), the last two (nrow, k) in N·m/rad and N·m·s/rad:
        MuJoCo steps both with the joint, the spring from where the joint is.
        """
        batch, ids, dofs = self.batch, self.ids[joints], self.dofs[joints]
        stiffness, damping, rest = (
            batch.expand(name) for name in ("jnt_stiffness", "dof_damping", "qpos_spring")
        )
        at, qpos, own = (rows, self.columns(joints)), self.qpos[joints], []

        def give(torque: np.ndarray, more: np.ndarray, damper: np.ndarray) -> None:
            if not own:
                # copies: what all other effects have written
                own.extend((stiffness[rows, ids], damping[rows, dofs], rest[rows, qpos]))
            k, d, slack = own
            total = np.maximum(k + more, LEAST_STIFFNESS)
            stiffness[rows, ids] = k + more
            rest[rows, qpos] = (k * slack + more * self.q[at]) / total
            damping[rows, dofs] = d + damper

        return give

    def _balance(self) -> np.ndarray | None:
        """What carries the weight continuously, (nsim, nv) N·m, kept up to date, or None."""
        balanced = np.tile(self.schedule.balanced, self.nvariant)
        if not balanced.all():
            self.batch.expand("body_gravcomp")[~balanced] = 0.0
            if not balanced.any():
                return None
        return self.batch.bind("qfrc_gravcomp")

    def _carrying(self, balance: np.ndarray) -> Callable[[int], tuple[np.ndarray, np.ndarray]]:
        """What carries the weight at a plant tick, by the machine and by MuJoCo.

        Each (nsim, njoint) N·m on average until the next, as it is held meanwhile. The machine
        carries what it knows of, times a factor; `balance` the real weight.
        """
        factor = self.compensation_factor
        wrong = self.other_weight | (factor != 1).any(axis=1)
        wrong &= np.tile(self.schedule.balanced, self.nvariant)
        nominal = GravityCompensation(self.batch, self.joints) if wrong.any() else None
        held = self.until_next()

        def carrying(tick: int) -> tuple[np.ndarray, np.ndarray]:
            real = held(tick, balance[:, self.dofs])
            if nominal is None:
                return real, real
            return np.where(wrong[:, None], factor * nominal(self._halfway(tick)), real), real

        return carrying

    def until_next(self) -> Callable[[int, np.ndarray], np.ndarray]:
        """What extends a force, as the last step left it, to its mean until the next plant tick.

        Called with each plant tick in turn and the force there.
        """
        last: list[np.ndarray] = []

        def held(tick: int, now: np.ndarray) -> np.ndarray:
            now = now.copy()
            before = last.pop() if last else now
            last.append(now)
            return now + (now - before) * self._halfway(tick)

        return held

    def _halfway(self, tick: int) -> float:
        """Time from the last forces to the middle of a plant tick, over that between the two last.

        A step evaluates its forces in its middle; those of the first tick are of the start.
        """
        period, half_step = self.plant_period_s, 0.5 * self.batch.model.opt.timestep
        return (half_step + 0.5 * period) / (period - half_step if tick == 1 else period)

    def _brake(self) -> Callable[[int, np.ndarray], np.ndarray | float]:
        """Back-EMF as damping of the joints; what it takes beside that, N·m, at a tick and dq.

        A step of MuJoCo takes damping at its end, which is early by half a step; held from the
        beginning of a tick it is late by half a tick. In shares that cancel it is of second order,
        for ticks of one step the rule of Crank and Nicolson (1947).
        """
        damping, powered = self.batch.expand("dof_damping"), self.schedule.powered
        own = damping[:, self.dofs].copy()
        back_emf = self._per_simulation(self.schedule.drive.back_emf)
        later = self.nstep / (self.nstep + 1)
        damping[:, self.dofs] = own + later * back_emf
        recording = self.recording

        def brake(tick: int, dq: np.ndarray) -> np.ndarray | float:
            on = 1.0 if powered is None else powered[tick][recording]
            if powered is not None:
                damping[:, self.dofs] = own + later * back_emf * on
            return (1 - later) * back_emf * on * dq

        return brake

    def _look_ahead(self) -> np.ndarray:
        """Damping (nsim, njoint) with which the loop is no later than the real one."""
        if self.ahead.any():
            self.batch.expand("dof_armature")[:, self.dofs] += self.ahead * self.kd
            self.inertia_changed = True
        return self.kd + self.ahead * self.kp

    def _center_damping(self) -> None:
        """Take the damping that joints have at the start in the middle of a step.

        MuJoCo takes it at the end, v' = (M + hD)⁻¹ (M v + hτ). With M − hD/2 in place of M that is
        the rule of Crank and Nicolson; with what is taken off here a joint alone slows down as
        exp(−hD/M), and M stays positive (Scharfetter and Gummel, 1969). Not where something gives
        between motor and link, as a motor alone is lighter.
        """
        model, damping = self.batch.model, self.batch.expanded("dof_damping")
        damping = (model.dof_damping if damping is None else damping)[..., self.dofs]
        damping = damping * ~self.transmission.gives
        if damping.any():
            alone = 1 / np.diag(np.linalg.inv(self._mass))
            share = model.opt.timestep * damping / alone
            kept = np.divide(share, np.expm1(share), out=np.ones_like(share), where=share > 0)
            self.batch.expand("dof_armature")[:, self.dofs] -= alone * (1 - kept)
            self.inertia_changed = True

    @cached_property
    def _mass(self) -> np.ndarray:
        """Mass matrix of the joints (n, n) in the pose of the model's zeros."""
        model = self.batch.model
        data, mass = mujoco.MjData(model), np.zeros((model.nv, model.nv))
        mujoco.mj_forward(model, data)
        mujoco.mj_fullM(model, data, mass)
        return mass[np.ix_(self.dofs, self.dofs)]

    def _faster(self, period_s: float) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
        """By how much joints are faster half a physics step later, rad/s.

        Called every `period_s` with velocity and torque (nsim, njoint). The acceleration is that
        of the last period, and what a joint alone has of the change of its torque since then. It
        is zero where the motion might turn, as dry friction may hold there, and where something
        gives between motor and link, of which forces change within a step.
        """
        last: list[tuple[np.ndarray, np.ndarray]] = []
        half, mobility = 0.5 * self.batch.model.opt.timestep, 1 / np.diag(self._mass)
        rigid = half * ~self.transmission.gives

        def faster(dq: np.ndarray, torque: np.ndarray) -> np.ndarray:
            before, applied = last.pop() if last else (dq, torque)
            last.append((dq, torque))
            ddq = (dq - before) / period_s
            ddq += mobility * (torque - applied)
            later = (dq + (period_s + half) * ddq) * dq
            # one while less than that part of the speed is lost, continuously to zero
            surely = KEPT * dq**2
            goes_on = np.minimum(np.maximum(later, 0.0), surely)
            ddq *= rigid * np.divide(goes_on, surely, out=goes_on, where=surely > 0)
            return ddq

        return faster

    def _split_lead(self) -> None:
        """Lead commands by whole ticks, as each is in force from one of them on."""
        whole = np.floor(self.command_lead_s / self.period_s + WHOLE) * self.period_s
        self.sampled_later_s = self.command_lead_s - whole
        self.command_lead_s = whole

    def _start(self) -> None:
        batch = self.batch
        start_dq = self._per_simulation(self.schedule.start_dq)
        start_q = self.start_q - self.sampled_later_s * start_dq
        batch.qpos[:, self.qpos] = start_q - self.encoder_offset
        batch.qvel[:, self.dofs] = start_dq + self.hidden_start[..., 2]
        batch.forward()
        for prepare in self.settle:
            prepare(self)


def finer(model: mujoco.MjModel, joints: tuple[str, ...]) -> int:
    """Times as fine as usual: more where more moves than the driven joints."""
    return EXTENDED if model.nv > len(joints) else 1
