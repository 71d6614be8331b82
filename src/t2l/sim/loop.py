"""What every control loop of a plant's variants has: signals, and the places where effects act."""

from collections.abc import Callable, Iterable

import mujoco
import numpy as np

from t2l.sim.schedule import Schedule
from t2l.sim.transmission import Transmission

ROOM = 0.05  # numerics: of what can be held, to the balance at the start
HELD, PHASE = 3, 4  # format: of `hidden_start`


def over_ticks(change: Callable) -> Callable:
    """Mark what acts in a loop as fit for several ticks that follow each other, in one call.

    It gets the ticks (k,), and signals (k, nsim, njoint) in place of (nsim, njoint). What it asks
    the batch is of the first tick.
    """
    change.over_ticks = True
    return change


def each_tick(signal: np.ndarray) -> Iterable[np.ndarray]:
    """A signal at each tick, (nsim, njoint), that can be written to."""
    return signal.reshape(-1, *signal.shape[-2:])


class Loop:
    """Every variant of a plant under every recording's commands.

    Simulation i is variant ``i // nrec`` on recording ``i % nrec``. What differs between variants
    is written by `t2l.effects` into the batch's expanded fields and into the attributes below.

    Attributes:
        batch: the simulations, or what stands for them; each kind of loop makes its own.
        real_period_s: of the loop that is simulated, by a coarser one or by itself.
        plant_ticks: how often between two ticks what acts between controller and joint is computed;
            the torque that the controller asks for is held meanwhile.
        in_order: whether an effect acts at several places of which one knows of another, so that a
            tick is done before the next begins.
        recording: (nsim,) index of the recording of each simulation.
        ids, dofs, qpos: (njoint,) indices and addresses of the driven joints.
        kp, kd: (nsim, njoint) gains the loop really uses.
        encoder_offset: (nsim, njoint) rad, measured minus true position.
        start_q: (nsim, njoint) rad, measured.
        moving: (nsim, 1) bool, whether the recording may begin in motion.
        taken: (nsim, njoint) N·m that the motion takes at the start, where it is known.
        ahead: (nsim, njoint) s, how far the loop looks ahead to be no later than the real one.
        hidden_start: (nsim, njoint, 5) angle and velocity with which what no encoder sees starts,
            beyond its rest under load, rad and rad/s; what to add to `Schedule.start_dq`; the
            torque that what remembers holds then, beyond what balances, as a share of what it can;
            and the phase of what swings freely, rad.
        q, dq: (nsim, njoint) rad and rad/s of the joints at the present plant tick.
        middle_dq: likewise halfway to the next, if they go on as before.
        command, measured, measured_dq: (nsim, njoint) rad and rad/s of the present tick, as they
            reach the controller after all filters; for what changes what it makes of them.
        transmission: between motors and links, of (nsim, njoint).
        command_lead_s: (nsim, njoint) s, by how much commands are in force before their time.
        command_delay_s: (nsim, njoint) s, by how much later than their time they arrive.
        command_filters: called with (tick, q_des), change q_des (nsim, njoint) in place. Each gets
            what the ones before left; what was earlier it keeps itself, see `t2l.sim.delay`.
        feed_forward_filters: called with (tick, torque), change Kd dq_des + tau_ff in place,
            likewise; where neither is commanded they are not called.
        controller_filters: called with (tick, torque), change what the loop computes, the gravity
            compensation that it gives included, in place.
        motor_filters: called with (plant tick, torque), change the motor torque, any gravity
            compensation included, in place.
        sensor_filters: called with (tick, q, dq), change what encoders read in place.
        feedback_filters: called with (tick, q, dq), change what of that reaches the controller, in
            place; the log keeps what the encoders read.
        compensation_factor: (nsim, njoint) of the modelled weight that is compensated.
        joint_torques: called with (plant tick, q, dq, torque), add to the last in place; q and dq
            are of the joints in the middle of the plant tick, if they go on as before.
        added_friction: (nsim, njoint) N·m of Coulomb friction beside the MJCF's own.
        friction: called with (plant tick, dq, motor torque, level), add to the last in place;
            dq likewise.
        bristles: (nsim, njoint) N·m of friction at rest that acts as a joint torque.
        stateless: of the motor filters and joint torques those that remember nothing, by place.
        settle: called once with the loop after the start state is set.
        other_weight: (nsim,) bool, where gravity or masses are not the model's, which is all that
            any compensation knows.
        inertia_changed: set by effects that write masses or armature, whose derived constants
            must then follow.
    """

    def __init__(
        self, model: mujoco.MjModel, joints: tuple[str, ...], schedule: Schedule, nvariant: int
    ):
        self.schedule, self.joints, self.nvariant = schedule, joints, nvariant
        self.nrec = len(schedule.kp)
        self.real_period_s = schedule.period_s / schedule.coarseness
        self.plant_ticks = 1
        self.in_order = False
        # (nsim,) of which recording each simulation is
        self.recording = np.tile(np.arange(self.nrec), nvariant)
        self.ids = np.array([model.joint(name).id for name in joints])
        self.dofs = np.array([model.joint(name).dofadr[0] for name in joints])
        self.qpos = np.array([model.joint(name).qposadr[0] for name in joints])
        self.kp, self.kd = self._per_simulation(schedule.kp), self._per_simulation(schedule.kd)
        self.start_q = self._per_simulation(schedule.start_q)
        self.encoder_offset = np.zeros_like(self.kp)
        late = (schedule.period_s - self.real_period_s) / 2
        self.ahead = np.full_like(self.kp, late)
        self.hidden_start = np.zeros((*self.kp.shape, 5))
        if schedule.phase is not None:
            self.hidden_start[..., PHASE] = schedule.phase[self.recording]
        self.transmission = Transmission.rigid(self.kp.shape)
        self.command_lead_s = np.zeros_like(self.kp)
        self.command_delay_s = np.zeros_like(self.kp)
        self.added_friction = np.zeros_like(self.kp)
        self.command_filters: list[Callable] = []
        self.feed_forward_filters: list[Callable] = []
        self.controller_filters: list[Callable] = []
        self.motor_filters: list[Callable] = []
        self.sensor_filters: list[Callable] = []
        self.feedback_filters: list[Callable] = []
        self.compensation_factor = np.ones_like(self.kp)
        self.joint_torques: list[Callable] = []
        self.friction: list[Callable] = []
        self.bristles = np.zeros_like(self.kp)
        self.taken: np.ndarray | None = None
        self.moving = schedule.may_move[self.recording, None]
        self.stateless: dict[str, list[Callable]] = {"motor_filters": [], "joint_torques": []}
        self.settle: list[Callable] = []
        self.other_weight = np.zeros(len(self.kp), bool)
        self.inertia_changed = False
        self.motor_limits = torque_limits(model, joints)

    @property
    def period_s(self) -> float:
        """From tick to tick."""
        return self.schedule.period_s

    @property
    def plant_period_s(self) -> float:
        """From plant tick to plant tick."""
        return self.period_s / self.plant_ticks

    def clock_s(self, tick: int | np.ndarray) -> np.ndarray:
        """What the log's clock shows in the middle of a plant tick, (nsim, 1) s; or of several."""
        return self._since(self.schedule.clock_s, tick)

    def elapsed_s(self, tick: int | np.ndarray) -> np.ndarray:
        """Time since the start in the middle of a plant tick, (nsim, 1) s; or of several."""
        return self._since(self.schedule.elapsed_s, tick)

    def _since(self, start: np.ndarray | None, tick: int | np.ndarray) -> np.ndarray:
        begin = np.zeros(self.nrec) if start is None else start
        passed = (np.asarray(tick)[..., None] + 0.5) * self.plant_period_s
        return (begin + passed)[..., self.recording, None]

    def logged(
        self, column: str, tick: int | np.ndarray, needed_by: str | None = None
    ) -> np.ndarray | None:
        """An optional column at a plant tick, (nsim, njoint), or several; as `Schedule.column`."""
        values = self.schedule.column(column, needed_by)
        if values is None:
            return None
        return values[tick // self.plant_ticks].take(self.recording, axis=-2)

    @property
    def places(self) -> dict[str, list[Callable]]:
        """Where effects act, by name, in the order in which a tick comes to them."""
        names = (
            "sensor_filters", "feedback_filters", "command_filters", "controller_filters",
            "motor_filters", "friction", "joint_torques",
        )  # fmt: skip
        return {name: getattr(self, name) for name in names}

    def loads(self) -> Callable[[int | np.ndarray], np.ndarray]:
        """What tells N·m that weight and velocity ask for at a plant tick, or at several.

        The present tick gives (nsim, njoint), ticks (k,) give (k, nsim, njoint); as MuJoCo's
        qfrc_bias.
        """
        bias = self.batch.bind("qfrc_bias")
        return lambda tick: bias[:, self.dofs]

    def torques_at_rest(self) -> np.ndarray:
        """N·m (nsim, njoint) on joints that rest at the start, of what remembers nothing."""
        return self._at_rest("joint_torques", np.zeros_like(self.start_q))

    def friction_at_rest(self, motor: np.ndarray) -> np.ndarray:
        """N·m (nsim, njoint) up to which joints are held where motors give a torque (likewise)."""
        own = self.batch.model.dof_frictionloss[self.dofs]
        level, still = self.added_friction + own + self.bristles, np.zeros_like(self.kp)
        for add in self.friction:
            add(0, still, motor, level)
        return np.maximum(level, 0.0)

    def given_at_rest(self, demand: np.ndarray) -> np.ndarray:
        """What motors that remember nothing make there of a demand, N·m (nsim, njoint)."""
        return self._at_rest("motor_filters", demand.copy())

    def _at_rest(self, place: str, torque: np.ndarray) -> np.ndarray:
        moving = [getattr(self, name, None) for name in ("q", "dq", "middle_dq")]
        self.q, self.dq = self.start_q - self.encoder_offset, np.zeros_like(self.start_q)
        self.middle_dq = self.dq
        state = (self.q, self.dq) if place == "joint_torques" else ()
        for change in self.stateless[place]:
            change(0, *state, torque)
        self.q, self.dq, self.middle_dq = moving
        return torque

    def _per_simulation(self, values: np.ndarray) -> np.ndarray:
        return np.tile(values, (self.nvariant, 1)).astype(float)

    def rows(self, variants: slice) -> slice:
        """The simulations of `variants`."""
        return slice(variants.start * self.nrec, variants.stop * self.nrec)

    def columns(self, joints: np.ndarray) -> np.ndarray | slice:
        """`joints` as an index into signals (nsim, njoint), a slice where it is all of them."""
        return slice(None) if len(joints) == len(self.joints) else joints

    def held_at_start(
        self,
        rows: slice,
        joints: np.ndarray,
        balance: np.ndarray,
        unit: np.ndarray,
        limit: np.ndarray,
    ) -> np.ndarray:
        """What is held at the start, (nrow, k), by the first that asks: the rest is in balance.

        Args:
            balance: what is held in balance, as far as it is known.
            unit: of which `hidden_start` says a share.
            limit: of what can be held. There a share more would do nothing, so that no derivative
                tells which is the right one: in motion, a balance comes nearly so far.
        """
        at, room = (rows, joints, HELD), np.where(self.moving[rows], 1 - ROOM, 1.0) * limit
        share = self.hidden_start[at].copy()
        self.hidden_start[at] = 0.0
        within = np.minimum(np.maximum(balance, -room), room)
        return np.minimum(np.maximum(within + share * unit, -limit), limit)

    def per_row(self, values: np.ndarray) -> np.ndarray:
        """(nvariant, k) values as (nvariant * nrec, k), one row a simulation."""
        return np.repeat(values, self.nrec, axis=0)


def torque_limits(model: mujoco.MjModel, joints: tuple[str, ...]) -> np.ndarray:
    """(njoint, 2) N·m that the MJCF allows each joint's actuators, infinite where it is silent."""
    limits = np.full((len(joints), 2), (-np.inf, np.inf))
    for i, name in enumerate(joints):
        joint = model.joint(name).id
        if model.jnt_actfrclimited[joint]:
            limits[i] = model.jnt_actfrcrange[joint]
    return limits
