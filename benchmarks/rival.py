"""Friction, damping and armature of a real FR3, fitted by t2l and by mujoco.sysid.

`T2L_STUDY_DATA` names the folder with `fr3_gain_grid/`, recordings at 49 gains. Ten of them, spread
over the gains, are fitted; the others report the error. Both fit the same 21 numbers from the same
starts within the same bounds, on one core; of several starts the one is taken that leaves least of
what was fitted. mujoco.sysid is given the plant that t2l simulates, with position actuators at the
loop's rate, and the residual in rad, that of t2l: its own divides each joint by its motion.
"""

import os
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks import mujoco_sysid, one_core
from benchmarks.recordings import spread_cells
from t2l.effects.registry import builtin
from t2l.effects.term import Layout, Term
from t2l.identify.fitting import run as run_fits
from t2l.identify.least_squares import LeastSquares
from t2l.identify.prediction import Predictor, Request
from t2l.recordings.log import read_recordings
from t2l.recordings.recording import Recording

FITTED = 10
# MuJoCo's attribute of a joint: effect and parameter in t2l
NAMES = {
    "frictionloss": ("coulomb_friction", "torque"),
    "damping": ("viscous_friction", "damping"),
    "armature": ("armature", "inertia"),
}
# beyond the MJCF's, every joint: small beside what a joint of this arm has
START = {"frictionloss": 0.1, "damping": 0.1, "armature": 0.01}
STARTS = {"one start": (1.0,), "three starts": (1.0, 3.0, 10.0)}  # times these
MAX_ITERATIONS = 100
COARSE, COARSE_ITERATIONS = 4, 30  # periods of the loop in a tick of t2l's first fits, of several


def run() -> pd.DataFrame:
    """One row a fit; what it found is printed above."""
    data = os.environ.get("T2L_STUDY_DATA")
    if not data:
        return pd.DataFrame({"skipped": ["T2L_STUDY_DATA does not name the folder of the data"]})
    os.sched_setaffinity(0, one_core.first())
    tested, fitted = spread_cells(read_recordings(Path(data) / "fr3_gain_grid"), FITTED)
    rows = [of_t2l("the MJCF as it is", fitted, tested, ())]
    for name, starts in STARTS.items():
        for program, fit in (("t2l", of_t2l), ("mujoco.sysid", of_rival)):
            rows.append(fit(f"{program}, {name}", fitted, tested, starts))
            print(" | ".join(map(str, rows[-1].values())), flush=True)
    return pd.DataFrame(rows)


def of_t2l(
    name: str, fitted: Sequence[Recording], tested: Sequence[Recording], starts: Sequence[float]
) -> dict:
    """A row of a fit by t2l; without a start the plant is left as it is."""
    predictor = Predictor(fitted[0].robot, fitted, threads=1)
    layout = bounded(predictor)
    size = layout.encode({e: {p: np.array([START[of]])} for of, (e, p) in NAMES.items()})
    mask, found = np.ones(len(predictor.samples), bool), []

    def fitting() -> None:
        fits = [LeastSquares(layout, times * size, size=size) for times in starts]
        if len(fits) > 1:
            coarse = predictor.of(fitted, COARSE)
            for fit in fits:
                run_fits([fit], coarse, mask, COARSE_ITERATIONS)
        best = min(fits, key=lambda fit: fit.loss)
        best = best.again() if len(fits) > 1 else best
        run_fits([best], predictor, mask, MAX_ITERATIONS)
        found.append(best.u)

    seconds = timed(fitting) if starts else 0.0
    u = found[0] if found else 0 * size
    told(name, u)

    def error(recordings: Sequence[Recording]) -> float:
        of = predictor.of(recordings)
        (q,) = of.predict([Request(layout, u[None])])
        return float(np.sqrt(np.mean((q[0] - of.samples.q) ** 2)))

    return row(name, error(fitted), error(tested), seconds)


def bounded(predictor: Predictor) -> Layout:
    """The effects on all joints, between nothing at all and what the rival may give."""
    model, joints = predictor.model(), tuple(range(len(predictor.joints)))
    layout = Layout([Term(builtin()[effect], joints) for effect, _ in NAMES.values()])
    dofs = [model.joint(joint).dofadr[0] for joint in predictor.joints]
    for attribute, (effect, _) in NAMES.items():
        own = getattr(model, f"dof_{attribute}")[dofs]
        at = [i for i, slot in enumerate(layout.slots) if slot.term.effect.name == effect]
        layout.lower[at] = -own
        layout.upper[at] = mujoco_sysid.UPPER[attribute] - own
    return layout


def of_rival(
    name: str, fitted: Sequence[Recording], tested: Sequence[Recording], starts: Sequence[float]
) -> dict:
    """A row of a fit by mujoco.sysid."""
    found = []

    def fitting() -> None:
        for times in starts:
            start = {attribute: times * value for attribute, value in START.items()}
            parameters = mujoco_sysid.fit(fitted, start, own_residual=False)
            found.append((mujoco_sysid.rmse(fitted, parameters), parameters))

    seconds = timed(fitting)
    least, best = min(found, key=lambda one: one[0])
    told(name, best.as_vector() - best.as_nominal_vector())
    return row(name, least, mujoco_sysid.rmse(tested, best), seconds)


def row(name: str, fitted_rad: float, tested_rad: float, seconds: float) -> dict:
    return {
        "fit": name,
        "error of the fitted recordings, mrad": round(1e3 * fitted_rad, 3),
        "error of the others, mrad": round(1e3 * tested_rad, 3),
        "seconds": round(seconds, 1),
    }


def told(name: str, added: np.ndarray) -> None:
    """Print what a fit adds to the MJCF's friction, damping and armature, joint by joint."""
    for attribute, values in zip(NAMES, np.reshape(added, (len(NAMES), -1)), strict=True):
        print(f"{name}: {attribute} {np.round(values, 3).tolist()}")


def timed(call: Callable) -> float:
    """Seconds of this process and its threads."""
    start = time.process_time()
    call()
    return time.process_time() - start
