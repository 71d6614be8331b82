"""A model of a real robot in the simulator's place: its loop, and the effects that logs showed.

The training simulator is coarse and knows no effect. A twin runs the loop of the machine at its own
rate, with every effect of a model that `t2l explain` wrote. An `Environment` steps through either.
"""

from dataclasses import dataclass

import numpy as np

from t2l.errors import ConfigurationError
from t2l.identify.loop_stability import Loops, plants
from t2l.identify.model import Model
from t2l.identify.prediction import with_effects
from t2l.identify.simulation import made_loop
from t2l.recordings.recording import CONTINUOUS, Recording
from t2l.robots import Robot
from t2l.sim.batch import make_batch
from t2l.sim.sampled_loop import longest_stable_s
from t2l.sim.schedule import Schedule
from t2l.tasks import Rewarded
from t2l.tasks.task import OF_JOINTS


@dataclass(frozen=True)
class Machine:
    """What recordings and a model fitted to them say of a robot.

    Attributes:
        model: with its effects.
        control_rate_hz: of its loop.
        gravity_compensation: as in a `Recording`.
    """

    model: Model
    control_rate_hz: float
    gravity_compensation: bool | str

    @classmethod
    def of(cls, model: Model, recordings: list[Recording], robot: Robot) -> "Machine":
        """Of a model, and the recordings of a robot that it is to explain.

        Raises:
            ConfigurationError: they are of another robot, or were not made by one loop.
        """
        for what, found, allowed in (
            ("robot", model.robot, robot.name), ("joints", recordings[0].joints, robot.joints),
        ):  # fmt: skip
            if found != allowed:
                raise ConfigurationError(
                    f"{what} of the recordings: found {found}; allowed: {allowed}, of the task"
                )
        loops = {(r.control_rate_hz, r.gravity_compensation) for r in recordings}
        if len(loops) > 1:
            found = "; ".join(f"{rate:g} Hz, {how}" for rate, how in sorted(loops, key=str))
            raise ConfigurationError(
                f"control_rate_hz and gravity_compensation of the recordings: found {found}; "
                "allowed: the same in all, as a twin has one loop"
            )
        return cls(model, *loops.pop())

    def unstable(self, robot: Robot, kp: np.ndarray, kd: np.ndarray) -> str:
        """Why its loop throws the joints about at home under gains (njoint,); nothing if not.

        Nothing is said where an effect changes the loop itself, or the base floats.
        """
        rate = np.array([self.control_rate_hz])
        at_home = Loops(["home"], kp[None], kd[None], robot.home[None], rate, rate, {})
        loop = plants(self.model, robot.joints, at_home)
        longest_s = 1 / self.control_rate_hz if loop is None else longest_stable_s(*loop, 1 / rate)
        if longest_s >= 1 / self.control_rate_hz:
            return ""
        return (
            f"the loop is unstable at {self.control_rate_hz:g} Hz under Kp up to {kp.max():g} and "
            f"Kd up to {kd.max():g}; allowed: a step of at most {1e3 * longest_s:.3g} ms, which is "
            f"{1 / longest_s:.0f} Hz"
        )


def check_task(task: Rewarded) -> None:
    """Whether a twin does a task as the machine would.

    Raises:
        ConfigurationError: a model of the joints cannot show it.
    """
    if beyond := task.beyond_joints:
        raise ConfigurationError(
            f"recordings of a robot, for the task {task.name}: found {beyond}; allowed: no "
            f"recordings, or {OF_JOINTS}"
        )


class Twin:
    """`n` machines that begin episodes together, in an `Environment`'s hands like a `Simulator`.

    Args:
        kp, kd: (njoint,) N·m/rad and N·m·s/rad.
        command_rate_hz: at which commands come.
        longest_s: of an episode.

    Attributes:
        batch: the task's scene, its joints where encoders see them.
        timestep_s: of the loop.

    Raises:
        ConfigurationError: see `check_task`.
    """

    def __init__(
        self,
        machine: Machine,
        task: Rewarded,
        kp: np.ndarray,
        kd: np.ndarray,
        n: int,
        command_rate_hz: float,
        longest_s: float,
        threads: int = 1,
    ):
        check_task(task)
        self.joints, self.n = task.robot.joints, n
        self.timestep_s = 1.0 / machine.control_rate_hz
        self.batch = make_batch(task.model, n, threads)
        self._machine, self._gains, self._threads = machine, (kp, kd), threads
        self._ticks = round(longest_s * machine.control_rate_hz) + 1
        self._command_period_s = np.full(n, 1.0 / command_rate_hz)
        self._q, self._dofs = task.arm_qpos, task.arm_dofs
        layout, u = machine.model.vector(self.joints)
        self._variants = [(layout, u[None])]
        extending = [term for term in layout.terms if term.effect.extends]
        self._model = with_effects(machine.model.robot, self.joints, extending)

    @property
    def q(self) -> np.ndarray:
        """(n, njoint) rad, as encoders read it."""
        return self.batch.qpos[:, self._q]

    @property
    def dq(self) -> np.ndarray:
        """(n, njoint) rad/s, likewise."""
        return self.batch.qvel[:, self._dofs]

    def put(self, q: np.ndarray) -> None:
        """Let the scene show the joints at q; the machines stay where they are."""
        self.batch.qpos[:, self._q] = q

    def begin(self, ids: np.ndarray, qpos: np.ndarray) -> None:
        """Put all machines at rest at qpos (n, nq); some of them alone stay as they ended."""
        if len(ids) < self.n:
            return
        self.batch.qpos[:] = qpos
        start, (kp, kd) = self.q.copy(), self._gains
        how, every = self._machine.gravity_compensation, np.ones(self.n, bool)
        schedule = Schedule(
            period_s=self.timestep_s,
            commands=np.tile(start, (self._ticks + 1, 1, 1)),
            kp=np.tile(kp, (self.n, 1)),
            kd=np.tile(kd, (self.n, 1)),
            start_q=start,
            start_dq=np.zeros_like(start),
            compensated=every & (how is True),
            balanced=every & (how == CONTINUOUS),
            sample_ticks=np.array([self._ticks]),
            command_period_s=self._command_period_s,
        )
        self._loop = made_loop(self._model, self.joints, schedule, 1, self._variants, self._threads)
        self._commands, self._tick = schedule.commands, 0
        # an effect may look for a command that is still to come: the last one goes on
        self._ahead = 2 + int(np.ceil(self._loop.command_lead_s.max() / self.timestep_s))
        self._going = self._loop.ticks()
        self._read()

    def step(self, q_des: np.ndarray, nstep: int) -> None:
        """Hold commands q_des (n, njoint) rad for `nstep` ticks."""
        for _ in range(nstep):
            self._commands[self._tick : self._tick + self._ahead] = q_des
            self._tick += 1
            self._read()

    def _read(self) -> None:
        """Let the scene show what encoders read at the tick that comes; NaN of what ran away."""
        q, dq = next(self._going)
        runs = self._loop.running[:, None]
        self.batch.qpos[:, self._q] = np.where(runs, q, np.nan)
        self.batch.qvel[:, self._dofs] = np.where(runs, dq, np.nan)
