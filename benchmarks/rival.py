"""Friction, damping and armature of a real FR3, fitted by t2l and by mujoco.sysid.

`T2L_STUDY_DATA` names the folder with `fr3_gain_grid/`, recordings at 49 gains. Ten of them, spread
over the gains, are fitted; the others report the error. Both fit the same 21 numbers from the same
start within the same bounds, on one core. mujoco.sysid is given the plant that t2l simulates, with
position actuators at the loop's rate, and each of the two residuals of `benchmarks.mujoco_sysid`.
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
MAX_ITERATIONS = 100


def run() -> pd.DataFrame:
    """One row a fit; what it found is printed above."""
    data = os.environ.get("T2L_STUDY_DATA")
    if not data:
        return pd.DataFrame({"skipped": ["T2L_STUDY_DATA does not name the folder of the data"]})
    os.sched_setaffinity(0, one_core.first())
    tested, fitted = spread_cells(read_recordings(Path(data) / "fr3_gain_grid"), FITTED)
    rows = [of_t2l("the MJCF as it is", fitted, tested, 0), of_t2l("t2l", fitted, tested)]
    for own in (False, True):
        name = f"mujoco.sysid, {'its own residual' if own else 'residual in rad'}"
        rows.append(of_rival(name, fitted, tested, own))
        print(pd.DataFrame(rows).to_markdown(index=False), flush=True)
    return pd.DataFrame(rows)


def of_t2l(
    name: str, fitted: Sequence[Recording], tested: Sequence[Recording], most: int = MAX_ITERATIONS
) -> dict:
    """A row, of no more than so many iterations; with none the plant is left as it is."""
    predictor = Predictor(fitted[0].robot, fitted, threads=1)
    model, joints = predictor.model(), tuple(range(len(predictor.joints)))
    layout = Layout([Term(builtin()[effect], joints) for effect, _ in NAMES.values()])
    dofs = [model.joint(joint).dofadr[0] for joint in predictor.joints]
    upper = {}
    for attribute, (effect, parameter) in NAMES.items():
        own = getattr(model, f"dof_{attribute}")[dofs]
        upper[effect] = {parameter: mujoco_sysid.UPPER[attribute] - own}
        at = [i for i, slot in enumerate(layout.slots) if slot.term.effect.name == effect]
        layout.lower[at] = -own
    layout.upper[:] = layout.encode(upper)
    size = layout.encode({e: {p: np.array([START[of]])} for of, (e, p) in NAMES.items()})
    fit = LeastSquares(layout, size.copy() if most else 0 * size, size=size)

    def fitting() -> None:
        run_fits([fit], predictor, np.ones(len(predictor.samples), bool), most)

    seconds = timed(fitting) if most else 0.0
    if most:
        told(name, fit.u)

    def error(recordings: Sequence[Recording]) -> float:
        of = predictor.of(recordings)
        (q,) = of.predict([Request(layout, fit.u[None])])
        return float(np.sqrt(np.mean((q[0] - of.samples.q) ** 2)))

    return row(name, error(fitted), error(tested), seconds)


def of_rival(
    name: str, fitted: Sequence[Recording], tested: Sequence[Recording], own_residual: bool
) -> dict:
    """A row of a fit by mujoco.sysid."""
    last = {}
    seconds = timed(lambda: last.update(found=mujoco_sysid.fit(fitted, START, own_residual)))
    found = last["found"]
    told(name, found.as_vector() - found.as_nominal_vector())
    return row(name, mujoco_sysid.rmse(fitted, found), mujoco_sysid.rmse(tested, found), seconds)


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
