"""The experiment that would tell two explanations apart, found by simulating both."""

from dataclasses import dataclass, replace

import numpy as np

from t2l.diagnose.settings import FASTEST_HZ
from t2l.effects.term import Layout
from t2l.hardware.excitation import chirp, envelope, sine
from t2l.identify.block_bootstrap import BEYOND_CHANCE
from t2l.identify.prediction import Predictor, Request
from t2l.recordings.recording import Recording
from t2l.robots.plant import position_ranges

DURATION_S = 4.0  # bound: a period of the slowest motion
RAMP_S = 0.25  # bound: to begin and to end
CHIRP_HZ = (0.5, FASTEST_HZ)  # bound: from slower than a controlled joint to faster
GAIN_FACTORS = (0.25, 1.0, 4.0)  # bound: of the stiffness: softer and stiffer than the recordings'
DISTINCT = BEYOND_CHANCE  # times the noise: a difference that a recording would show


@dataclass(frozen=True)
class Experiment:
    """A motion at some gains and by how much two models differ on it.

    Attributes:
        motion: what to command, in words.
        kp, kd: (njoint,) gains.
        difference_rad: RMS between the two predictions.
        noise_rad: of the recordings so far.
    """

    motion: str
    kp: np.ndarray
    kd: np.ndarray
    difference_rad: float
    noise_rad: float

    @property
    def sentence(self) -> str:
        """The advice."""
        gains = f"Kp {_list(self.kp)}, Kd {_list(self.kd)}"
        size = f"their predictions differ by {1e3 * self.difference_rad:.2g} mrad there"
        if self.difference_rad < DISTINCT * self.noise_rad:
            return (
                f"No motion tried tells them apart: even {self.motion} at {gains}, the best, "
                f"makes only {1e3 * self.difference_rad:.2g} mrad of difference, below "
                f"{DISTINCT:.1f} times the noise"
            )
        return f"Command {self.motion} at {gains}: {size}, the noise is {1e3 * self.noise_rad:.2g}"


def separating_experiment(
    predictor: Predictor,
    first: tuple[Layout, np.ndarray],
    second: tuple[Layout, np.ndarray],
    noise_rad: float,
) -> Experiment:
    """The motion and gains, of a few that the recordings suggest, where two models differ most.

    Args:
        first, second: layout and u (n,) of each model.
    """
    trials = [
        (motion, replace(recording, kp=factor * recording.kp, kd=damping * recording.kd))
        for motion, recording in _motions(predictor)
        for factor, damping in zip(GAIN_FACTORS, np.sqrt(GAIN_FACTORS), strict=True)
    ]
    trial = predictor.of([recording for _, recording in trials])
    q = trial.predict([Request(layout, u[None]) for layout, u in (first, second)])
    squares = np.nan_to_num((q[0][0] - q[1][0]) ** 2)
    count = np.bincount(trial.samples.recording)
    rms = np.sqrt(np.bincount(trial.samples.recording, squares) / count)
    best = int(np.argmax(rms))
    motion, recording = trials[best]
    return Experiment(motion, recording.kp, recording.kd, float(rms[best]), noise_rad)


def _motions(predictor: Predictor) -> list[tuple[str, Recording]]:
    """Motions around the middle of what was recorded, as large, and within the joints' range."""
    like, samples = predictor.recordings[0], predictor.samples
    joints = range(len(predictor.joints))
    low = np.array([samples.q[samples.joint == j].min() for j in joints])
    high = np.array([samples.q[samples.joint == j].max() for j in joints])
    lowest, highest = position_ranges(predictor.model(), predictor.joints).T
    middle = np.clip((low + high) / 2, lowest, highest)
    room = np.minimum(middle - lowest, highest - middle)
    # bound: rad, of a joint that hardly moved
    amplitude = np.minimum(np.maximum((high - low) / 2, 0.02), room)
    rate = like.command_rate_hz
    time = np.arange(int(DURATION_S * rate)) / rate
    shape = envelope(time, DURATION_S, RAMP_S)[:, None]
    motions = {
        f"a slow sine of {_list(amplitude)} rad at 0.25 Hz": sine(
            time, amplitude, np.full(len(middle), 1 / DURATION_S)
        ),
        f"a sine of {_list(amplitude)} rad at 1 Hz": sine(time, amplitude, np.ones(len(middle))),
        f"a chirp of {_list(amplitude / 2)} rad from 0.5 to 8 Hz": chirp(
            time, amplitude / 2, *CHIRP_HZ, DURATION_S
        ),
        f"steps of {_list(amplitude / 2)} rad every second": np.outer(
            np.where(time % 2 < 1, 1.0, -1.0), amplitude / 2
        ),
    }
    return [
        (f"{name} around {_list(middle)} rad", _recording(like, middle, time, offset * shape))
        for name, offset in motions.items()
    ]


def _recording(like: Recording, start, time, offset) -> Recording:
    # every row is a sample to compare; the value only sets the start
    q = np.repeat(start[None], len(time), axis=0)
    return replace(
        like, time=time, q_des=start + offset, dq_des=None, tau_ff=None, q=q, dq=None, tau=None
    )


def _list(values: np.ndarray) -> str:
    rounded = [f"{value:.2g}" for value in values]
    return rounded[0] if len(set(rounded)) == 1 else "/".join(rounded)
