"""First guesses that are read off the torque which a model lacks along the measured motion."""

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import uniform_filter1d

from t2l.detective.linear_loop import Section
from t2l.detective.responses import added_torques, excess
from t2l.diagnose.inverse_dynamics_residual import WINDOW_S
from t2l.effects.blame import blaming
from t2l.effects.effect import Effect
from t2l.effects.term import Layout
from t2l.identify.first_guesses import check_guess
from t2l.identify.prediction import Predictor
from t2l.identify.simulation import install
from t2l.sim.driven_loop import DrivenLoop

Model = tuple[Layout, np.ndarray]


def read_off(
    predictor: Predictor,
    sections: Sequence[Section],
    mask: np.ndarray,
    base: Model,
    model: Model,
    effects: Sequence[Effect],
) -> dict[str, list[dict[str, np.ndarray]]]:
    """Guesses of each effect from the torque that a model lacks.

    Args:
        mask: (nsample,) bool, where it may be looked at.
        base: of which the loop was linearised.
    """
    readers = [e for e in effects if type(e).read_off is not Effect.read_off]
    guesses: dict[str, list] = {effect.name: [] for effect in effects}
    if not readers:
        return guesses
    known, samples = _lacking(predictor, sections, base, model), predictor.samples
    clock = samples.time + np.array([r.time[0] for r in predictor.recordings])[samples.recording]
    where = [mask & (samples.joint == j) for j in range(len(predictor.joints))]
    for effect in readers:
        with blaming([effect], "to read a first guess off (read_off)"):
            of_joints = [
                effect.read_off(
                    known["q"][at], known["torque"][at], clock[at],
                    **{name: known[name][at] for name in effect.reads},
                )
                for at in where
            ]  # fmt: skip
            if any(found is None for found in of_joints):
                continue
            names = [parameter.name for parameter in effect.parameters]
            guess = {name: np.array([found[name] for found in of_joints]) for name in names}
            check_guess(effect, guess, len(of_joints))
            guesses[effect.name] += [guess, *effect.also(guess)]
    return guesses


def _lacking(
    predictor: Predictor, sections: Sequence[Section], base: Model, model: Model
) -> dict[str, np.ndarray]:
    """Torque that a model lacks about each sample, and what `Effect.reads` may ask for.

    (nsample,) each.
    """
    samples = predictor.samples
    found = {name: np.zeros(len(samples)) for name in ("q", "torque", "motor", "velocity")}
    (layout, u) = model
    for section in sections:
        group, path = section.motion.group, section.path
        more = added_torques(predictor, section, base, [(layout, u[None])])[0][:, 0]
        loop = DrivenLoop(predictor.model(layout.terms), predictor.joints, group.schedule, 1)
        with blaming([term.effect for term in layout.terms], "to lead it"):
            install(loop, [(layout, u[None])])
            motor = loop.motor_torque(path)[:, 0]
        recording, tick, _, joint = group.wanted
        at = group.schedule.sample_ticks[tick], recording, joint
        window = max(1, round(WINDOW_S / group.schedule.period_s))
        lacking = -uniform_filter1d(excess(predictor, section, base) + more, window, axis=0)
        of_ticks = {"q": path.q, "torque": lacking, "motor": motor, "velocity": path.dq}
        for name, values in of_ticks.items():
            found[name][group.held] = values[at]
    return found | {"recording": samples.recording}
