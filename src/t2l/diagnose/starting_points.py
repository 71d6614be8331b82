"""First guesses that are read off the torque which a model lacks."""

from collections.abc import Sequence

import numpy as np

from t2l.diagnose.inverse_dynamics_residual import missing_torque, motor_torque
from t2l.effects.blame import blaming
from t2l.effects.effect import Effect
from t2l.identify.first_guesses import check_guess
from t2l.identify.prediction import Predictor


def read_off(
    predictor: Predictor, mask: np.ndarray, effects: Sequence[Effect], residual: np.ndarray
) -> dict[str, list[dict[str, np.ndarray]]]:
    """Guesses of each effect from the torque that the model so far lacks."""
    readers = [e for e in effects if type(e).read_off is not Effect.read_off]
    guesses: dict[str, list] = {effect.name: [] for effect in effects}
    if not readers:
        return guesses
    torque, samples = missing_torque(predictor, residual), predictor.samples
    clock = samples.time + np.array([r.time[0] for r in predictor.recordings])[samples.recording]
    motor = motor_torque(predictor) if any(e.reads_motor for e in readers) else None
    where = [mask & (samples.joint == j) for j in range(len(predictor.joints))]
    for effect in readers:
        with blaming([effect], "to read a first guess off (read_off)"):
            of_joints = [
                effect.read_off(
                    samples.q[at],
                    torque[at],
                    clock[at],
                    **({"motor": motor[at]} if effect.reads_motor else {}),
                    **({"recording": samples.recording[at]} if effect.reads_recordings else {}),
                )
                for at in where
            ]
            if any(found is None for found in of_joints):
                continue
            names = [parameter.name for parameter in effect.parameters]
            guess = {name: np.array([found[name] for found in of_joints]) for name in names}
            check_guess(effect, guess, len(of_joints))
            guesses[effect.name] += [guess, *effect.also(guess)]
    return guesses
