"""Actuators identified under gains that are known, from all recordings of a robot at once.

A controller's gains are commanded, so they are no unknowns. Left free, one slow motion settles
only ratios such as Kd/Kp. Here each joint has an armature, a Coulomb and a viscous friction, a
constant torque and one scale of its torque, the same in every cell:

    τ = k (Kp (q_des − q) − Kd q̇) + τ0

The training simulator has no such constant; it is fitted so that nothing else takes its place. All
are fitted by least squares to the positions of all cells, in a plant whose control loop runs
at its own rate (`t2l.sim.servo`).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from t2l.effects.actuator import GUESS, Actuator
from t2l.effects.term import Layout, Term
from t2l.identify.actuators import IdentificationError, Identified, compared
from t2l.identify.fitting import run
from t2l.identify.least_squares import LeastSquares
from t2l.identify.prediction import Predictor
from t2l.identify.uncertainty import uncertainty
from t2l.recordings.recording import Recording
from t2l.sim.training_simulator import Parameters

ON_BOUND = 1e-3  # numerics: of a parameter's size
# numerics: relative gain of a round, below which the cheap steps end, and then the others: less
# than intervals by blocks of time can tell
NEAR, SETTLED = 0.1, 0.005
NAMES = tuple(parameter.name for parameter in Actuator.parameters)


@dataclass(frozen=True)
class Actuators:
    """What fits all recordings best; arrays are (njoint,).

    Attributes:
        values: by the names of `Actuator`'s parameters.
        intervals: (njoint, 2) each, 95 % by blocks of time.
        losses: (rounds, nrec) mean squared error of positions, rad².
        bounds: parameters and joints that ended on a bound.
    """

    values: Parameters
    intervals: Mapping[str, np.ndarray]
    losses: np.ndarray
    bounds: list[tuple[str, int]]


def identify_actuators(
    recordings: Sequence[Recording],
    rounds: int,
    threads: int = 1,
    progress: Callable[[int, float], None] = lambda iteration, loss: None,
) -> Actuators:
    """One set of actuators for recordings of a robot under several gains.

    The fit starts at the same `GUESS` for every joint of any robot, so that what the recordings do
    not show stays wrong, and is not read off the MJCF.

    Args:
        rounds: of the fit, at most.

    Raises:
        IdentificationError: the plant runs away under the first guess.
    """
    predictor = Predictor(recordings[0].robot, recordings, threads=threads)
    layout = Layout([Term(effect := Actuator(), tuple(range(len(predictor.joints))))])
    size = np.array([slot.size for slot in layout.slots])
    samples = predictor.samples
    every = np.ones(len(samples), bool)
    losses: list[np.ndarray] = []

    def after_round(fits) -> None:
        (fit,) = fits
        squares = np.nan_to_num(fit.residual**2, nan=np.inf)
        losses.append(
            np.array([squares[samples.recording == i].mean() for i in range(len(recordings))])
        )
        progress(len(losses) - 1, fit.loss)
        # a cheap step that is not taken shows that joints drive each other
        fit.done |= fit is near and fit.iterations > 0 and fit.gain == 0

    start = layout.encode({effect.name: GUESS})
    near = LeastSquares(layout, start, size, diagonal=True, tolerance=NEAR)
    run([near], predictor, every, rounds, after_round)
    # joints with parallel axes drive each other: now every parameter has a column of its own
    fit = LeastSquares(layout, near.u, size, tolerance=SETTLED)
    run([fit], predictor, every, rounds, after_round)
    if not np.isfinite(fit.loss):
        raise IdentificationError("the simulation of the recordings runs away under a first guess")
    estimate = uncertainty(fit, predictor, every)
    shape = (len(effect.parameters), -1)
    intervals = np.array([estimate.interval(i) for i in range(len(layout))]).reshape(*shape, 2)
    gap = np.minimum(fit.u - layout.lower, layout.upper - fit.u)
    ended = gap < ON_BOUND * np.where(layout.log, 1.0, size)
    return Actuators(
        {name: value[0] for name, value in layout.decode(fit.u[None])[effect.name].items()},
        dict(zip(NAMES, intervals, strict=True)),
        np.array(losses),
        [(layout.slots[i].parameter.name, layout.slots[i].joint) for i in np.flatnonzero(ended)],
    )


def in_simulator(
    recording: Recording,
    values: Parameters,
    bounds: list[tuple[str, int]],
    losses: np.ndarray,
    rate_hz: float,
) -> Identified:
    """A cell's training simulator with actuators that all cells share, against its recording.

    Args:
        losses: (rounds,) of this recording, rad².

    Raises:
        IdentificationError: see `actuators.identify`.
    """
    scale = values["torque_scale"]
    parameters = {
        "stiffness": scale * recording.kp,
        "damping": scale * recording.kd,
        "armature": values["armature"],
        "static_friction": values["friction"],
        # Coulomb friction is the same at rest and in motion
        "dynamic_friction_ratio": np.ones_like(scale),
        "viscous_friction": values["viscous_friction"],
    }
    return compared(recording, parameters, losses, bounds, rate_hz)
