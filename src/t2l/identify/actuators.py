"""CMA-ES on the spectral error of one recording: a population a generation, one batch."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from t2l.errors import T2LError
from t2l.identify.actuator_parameters import BOX, PARAMETERS, decode, encode, on_bound
from t2l.identify.cma_es import CMAES
from t2l.identify.initial_state import start_state
from t2l.identify.optimiser import Objective, Optimiser, minimise
from t2l.identify.spectral import mean_squared_error, spectral_error
from t2l.recordings.recording import Recording
from t2l.robots import make_robot
from t2l.robots.plant import position_controlled
from t2l.sim.training_simulator import Parameters, Simulator


class IdentificationError(T2LError):
    """A recording that cannot be identified from."""


@dataclass(frozen=True)
class Settings:
    """Of the search.

    Attributes:
        gains: `free`, or `known`, which takes all cells at once: `t2l.identify.known_gains`.
        iterations, population: generations, and simulations in each.
        sigma: first standard deviation in the box [0, 10] of every parameter.
        rate_hz: of the simulator's physics.
    """

    gains: str
    iterations: int
    population: int
    sigma: float
    rate_hz: float


@dataclass(frozen=True)
class Identified:
    """What fits a recording best.

    Attributes:
        parameters: (njoint,) each.
        losses: (iterations,) what was made small so far: the spectral error, rad² plus (rad/s)²,
            or under known gains the mean squared error of positions, rad².
        mse: mean squared error of positions over time and joints, rad².
        mse_dq: that of velocities, (rad/s)²; NaN where they were not measured.
        q, dq: (ntime, njoint) as simulated with them.
        bounds: parameters and joints that ended on a bound.
    """

    parameters: Parameters
    losses: np.ndarray
    mse: float
    mse_dq: float
    q: np.ndarray
    dq: np.ndarray
    bounds: list[tuple[str, int]]

    @property
    def s_star(self) -> float:
        """S* of the study, over x = (q, q̇): the sum of both errors (section IV-C)."""
        return self.mse + self.mse_dq


def identify(
    recording: Recording,
    settings: Settings,
    seed: int,
    threads: int = 1,
    progress: Callable[[int, float], None] = lambda iteration, loss: None,
) -> Identified:
    """Actuator parameters with which the simulator moves as the recording does.

    The search starts at the recording's own gains and the middle of the other ranges. Velocities
    count where they were measured.

    Raises:
        IdentificationError: the recording's commands do not fit the simulator's timestep, or
            positions are missing.
    """
    target = _target(recording, settings.rate_hz)
    robot = make_robot(recording.robot)
    plant = position_controlled(robot)
    simulator = Simulator(
        plant, robot.joints, robot.torque_limit, settings.population, settings.rate_hz, threads
    )
    objective = SpectralError(target, simulator)
    start = _first_guess(recording)
    search = CMAES(
        start, np.tile([0.0, BOX], (len(start), 1)), settings.sigma, settings.population, seed,
        loss=objective.loss, from_start=False,
    )  # fmt: skip
    losses: list[float] = []

    def after_round(searches: Sequence[Optimiser]) -> None:
        losses.append(search.loss)
        progress(len(losses) - 1, search.loss)

    minimise([search], objective, settings.iterations, after_round)
    parameters = {name: values[0] for name, values in decode(search.u[None]).items()}
    return compared(recording, parameters, np.array(losses), on_bound(parameters), settings.rate_hz)


def compared(
    recording: Recording,
    parameters: Parameters,
    losses: np.ndarray,
    bounds: list[tuple[str, int]],
    rate_hz: float,
) -> Identified:
    """The training simulator with parameters (njoint,) each, against a recording.

    Raises:
        IdentificationError: as `identify`.
    """
    target, robot = _target(recording, rate_hz), make_robot(recording.robot)
    simulator = Simulator(position_controlled(robot), robot.joints, robot.torque_limit, 1, rate_hz)
    q, dq = target.simulate(simulator, parameters)
    at = target.measured
    mse = float(mean_squared_error(q[:, at], target.q[at])[0])
    mse_dq = np.nan
    if target.dq is not None:
        mse_dq = float(mean_squared_error(dq[:, at], target.dq[at])[0])
    return Identified(parameters, losses, mse, mse_dq, q[0], dq[0], bounds)


@dataclass(frozen=True)
class Target:
    """A recording as the search needs it; `measured` are the rows with positions."""

    q_des: np.ndarray
    q: np.ndarray
    dq: np.ndarray | None
    start: tuple[np.ndarray, np.ndarray]
    measured: np.ndarray
    nstep: int

    def simulate(self, simulator: Simulator, parameters) -> tuple[np.ndarray, np.ndarray]:
        simulator.set_parameters(parameters)
        return simulator.simulate(self.q_des, *self.start, self.nstep)


class SpectralError(Objective):
    """What the training simulator makes of points in the box, against a recording.

    Residuals are positions at every measured row, in rad, and after them velocities where they
    were measured, in rad/s.
    """

    def __init__(self, target: Target, simulator: Simulator):
        self.target, self.simulator = target, simulator
        njoint = target.q.shape[1]
        self.signals = 1 if target.dq is None else 2
        self.rows = int(target.measured.sum())
        self.joints = np.tile(np.arange(njoint), self.signals * self.rows)

    def residuals(self, asked):
        return [self._of(points) for _, points in asked]

    def _of(self, points: np.ndarray) -> np.ndarray:
        target, at = self.target, self.target.measured
        q, dq = target.simulate(self.simulator, decode(points))
        errors = [q[:, at] - target.q[at]]
        if target.dq is not None:
            errors.append(dq[:, at] - target.dq[at])
        return np.concatenate([error.reshape(len(points), -1) for error in errors], axis=1)

    def loss(self, residuals: np.ndarray) -> np.ndarray:
        """Sum of the spectral errors (m,) of positions and velocities."""
        signals = residuals.reshape(len(residuals), self.signals, self.rows, -1)
        return np.sum([spectral_error(signals[:, i]) for i in range(self.signals)], axis=0)


def _target(recording: Recording, rate_hz: float) -> Target:
    nstep = rate_hz / recording.command_rate_hz
    if abs(nstep - round(nstep)) > 1e-6 or nstep < 0.5:
        raise IdentificationError(
            f"{recording.path or recording.name}: command_rate_hz: found "
            f"{recording.command_rate_hz:g}; allowed: a divisor of the simulator's {rate_hz:g} Hz"
        )
    unlike = {
        "control": recording.drifts, "skew_s": recording.skew.any(),
        "motor": recording.motor is not None,
    }  # fmt: skip
    if any(unlike.values()):
        key = next(key for key, is_so in unlike.items() if is_so)
        raise IdentificationError(
            f"{recording.path or recording.name}: key {key}: found it; allowed: recordings of "
            "commanded positions, of drives that give the torque they are asked for, whose joints "
            "are measured at the same time"
        )
    period = 1 / recording.command_rate_hz
    row = np.round((recording.time - recording.time[0]) / period).astype(int)
    n = row[-1] + 1
    shape = (n, len(recording.joints))
    q_des, q, dq = np.empty(shape), np.full(shape, np.nan), None
    last = np.searchsorted(row, np.arange(n), side="right") - 1
    q_des[:] = recording.q_des[last]
    q[row] = recording.q
    if recording.dq is not None:
        dq = np.full(shape, np.nan)
        dq[row] = recording.dq
    measured = ~np.isnan(q).any(axis=1)
    if dq is not None:
        measured &= ~np.isnan(dq).any(axis=1)
    if not measured[0] or measured.sum() < 10:  # bound: fewer samples tell nothing
        raise IdentificationError(
            f"{recording.path or recording.name}: q: found {measured.sum()} rows in which all "
            "joints are measured; allowed: at least 10, the first row among them"
        )
    return Target(q_des, q, dq, start_state(recording), measured, round(nstep))


def _first_guess(recording: Recording) -> np.ndarray:
    middle = decode(np.full((1, len(PARAMETERS) * len(recording.joints)), BOX / 2))
    return encode(middle | {"stiffness": recording.kp[None], "damping": recording.kd[None]})[0]
