"""Compare, diagnose and explain against their time limits; fits against bare MuJoCo and its sysid.

`benchmarks.recordings` says what is recorded, `benchmarks.mujoco_sysid` how the rival fits.
"""

import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from unittest.mock import patch

import numpy as np
import pandas as pd
from mujoco.batch import Batch

from benchmarks import mujoco_sysid, recordings
from benchmarks.bare_step import replays
from t2l.detective.data_split import split
from t2l.detective.ranking import diagnose
from t2l.diagnose.recordings_and_model import read_recordings_and_model
from t2l.effects.registry import builtin
from t2l.effects.term import Layout, Term
from t2l.identify.fitting import run as run_fits
from t2l.identify.least_squares import LeastSquares
from t2l.identify.prediction import Predictor, Request
from t2l.recordings.recording import Recording

COMPARE_S, EXPLAIN_S, DIAGNOSE_S = 10, 600, 60
HELD_OUT_CELLS = 10
VARIANTS = 20
REPEATS = 3

# MuJoCo's attribute of a joint: effect and parameter in t2l
NAMES = {
    "frictionloss": ("coulomb_friction", "torque"),
    "damping": ("viscous_friction", "damping"),
    "armature": ("armature", "inertia"),
}
START = {"frictionloss": 0.02, "damping": 0.02, "armature": 0.002}  # of both fits, every joint
MAX_ITERATIONS = 100

Row = tuple[str, str, str, str, str]


def run() -> pd.DataFrame:
    """Each row is printed as it comes."""
    rows = []
    for part in (compare_and_explain, diagnose_one, throughput, three_parameters):
        for row in part():
            print(" | ".join(row), flush=True)
            rows.append(row)
    print()
    columns = ["what", "measured", "bound or baseline", "ratio", "wanted"]
    return pd.DataFrame(rows, columns=columns)


def compare_and_explain() -> Iterator[Row]:
    """A grid of gains on the FR3, each command a process timed from its start."""
    everything = recordings.fr3_grid()
    fitted, held = recordings.spread_cells(everything, HELD_OUT_CELLS)
    what = f"{len(everything)} FR3 recordings"
    seconds = _t2l("compare", _paths(everything))
    yield _row(f"compare {what}", seconds, COMPARE_S, "s", "below 1")
    seconds = _t2l("explain", [*_paths(fitted), "--holdout", *_paths(held)])
    yield _row(f"explain {what}, {len(held)} held out", seconds, EXPLAIN_S, "s", "below 1")


def diagnose_one() -> Iterator[Row]:
    """One recording of 10 s, as a process; then in this process, to see what physics takes."""
    for hidden, robot in recordings.SINGLE_HIDDEN:
        folder = recordings.single(hidden, robot)
        what = f"diagnose one recording of 10 s, {robot} with {hidden}"
        yield _row(what, _t2l("diagnose", [str(folder)]), DIAGNOSE_S, "s", "below 1")
        physics, total = _physics_of_diagnose(folder)
        yield _row("on one core: its time in Batch.step", physics, total, "s", "")


def throughput() -> Iterator[Row]:
    """Physics steps a second of a fit and of Batch.step alone under the same torques, on one core.

    Then the fit's on all cores.
    """
    arm, _ = recordings.three_parameters()
    for robot, measured, most in (("FR3", recordings.fr3_grid(), 1.0), ("two-joint arm", arm, 0.2)):
        predictor = Predictor(measured[0].robot, measured, threads=1)
        on_all = Predictor(measured[0].robot, measured)
        terms = [Term(builtin()["coulomb_friction"], tuple(range(len(predictor.joints))))]
        layout = Layout(terms)
        u = np.linspace(0.0, most, VARIANTS)[:, None] * np.ones(len(layout))
        again = replays(predictor, terms, u)
        million_steps = 1e-6 * sum(replay.steps for replay in again)

        request = Request(layout, u)
        ours, bare, all_cores = _medians(
            lambda p=predictor, r=request: _seconds(lambda: p.predict([r])),
            lambda again=again: sum(replay.seconds() for replay in again),
            lambda p=on_all, r=request: _seconds(lambda: p.predict([r])),
        )
        what = f"{VARIANTS} variants of {len(measured)} recordings predicted, {robot}"
        rate = million_steps / ours
        yield _row(f"{what}: one core", rate, million_steps / bare, "M steps/s", "at least 0.70")
        what = f"... on {on_all.threads} cores, against one"
        yield _row(what, million_steps / all_cores, rate, "M steps/s", "")


def three_parameters() -> Iterator[Row]:
    """Friction, damping and armature of two joints, fitted by t2l and by mujoco.sysid."""
    fitted, held = recordings.three_parameters()
    truth = np.array([v for values in recordings.THREE_HIDDEN.values() for v in values.values()])
    last = {}

    def ours() -> float:
        return _seconds(lambda: last.update(ours=_fit_three(fitted)))

    for own_residual in (True, False):

        def theirs(own=own_residual) -> float:
            return _seconds(lambda: last.update(theirs=mujoco_sysid.fit(fitted, START, own)))

        our_s, their_s = _medians(ours, theirs)
        rival = "mujoco.sysid, its own residual" if own_residual else "mujoco.sysid, same residual"
        what = f"three parameters a joint against {rival}"
        yield _row(f"{what}: fit", our_s, their_s, "s", "")
        layout, u = last["ours"]
        parameters = last["theirs"]
        for name, part in (("fitted", fitted), ("held out", held)):
            error, their_error = _rmse(part, layout, u), mujoco_sysid.rmse(part, parameters)
            yield _row(f"{what}: RMSE {name}", 1e3 * error, 1e3 * their_error, "mrad", "")
        found = parameters.as_vector() - parameters.as_nominal_vector()
        values = layout.decode(u[None])
        ours_found = np.concatenate([values[effect][name][0] for effect, name in NAMES.values()])
        worst, their_worst = (100 * np.abs(v / truth - 1).max() for v in (ours_found, found))
        yield _row(f"{what}: worst parameter off by", worst, their_worst, "%", "")


def _t2l(command: str, arguments: Sequence[str]) -> float:
    """Seconds of a `t2l` command from the start of its process, with nothing to resume."""
    with tempfile.TemporaryDirectory() as folder:
        line = [sys.executable, "-m", "t2l", command, *arguments, "--out", f"{folder}/out"]
        start = time.perf_counter()
        done = subprocess.run(line, capture_output=True, text=True)
        seconds = time.perf_counter() - start
    if done.returncode:
        raise RuntimeError(f"t2l {command}: {done.stderr[-3000:]}")
    return seconds


def _paths(group: Sequence[Recording]) -> list[str]:
    return [str(recording.path) for recording in group]


def _physics_of_diagnose(folder: Path) -> tuple[float, float]:
    """Seconds in Batch.step and in all of a diagnosis, on one core."""
    model, measured, _ = read_recordings_and_model([folder])
    inside, step = [], Batch.step

    def timed(*args, **kwargs) -> None:
        inside.append(_seconds(lambda: step(*args, **kwargs)))

    with patch.object(Batch, "step", timed):
        total = _seconds(lambda: diagnose(model, split(model.robot, measured, threads=1)))
    return sum(inside), total


def _fit_three(measured: Sequence[Recording]) -> tuple[Layout, np.ndarray]:
    predictor = Predictor(measured[0].robot, measured)
    joints = tuple(range(len(predictor.joints)))
    layout = Layout([Term(builtin()[effect], joints) for effect, _ in NAMES.values()])
    start = layout.encode(
        {effect: {name: np.array([START[of]])} for of, (effect, name) in NAMES.items()}
    )
    fit = LeastSquares(layout, start, size=start)
    run_fits([fit], predictor, np.ones(len(predictor.samples), bool), MAX_ITERATIONS)
    return layout, fit.u


def _rmse(measured: Sequence[Recording], layout: Layout, u: np.ndarray) -> float:
    predictor = Predictor(measured[0].robot, measured)
    q = predictor.predict([Request(layout, u[None])])[0][0]
    return float(np.sqrt(np.mean((q - predictor.samples.q) ** 2)))


def _seconds(call: Callable) -> float:
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


def _medians(*timed: Callable[[], float]) -> np.ndarray:
    """Medians over interleaved repeats, so that a drifting machine shifts all alike."""
    return np.median([[call() for call in timed] for _ in range(REPEATS)], axis=0)


def _row(what: str, measured: float, baseline: float, unit: str, wanted: str) -> Row:
    return (
        what,
        f"{measured:.3g} {unit}",
        f"{baseline:.3g} {unit}",
        f"{measured / baseline:.2f}",
        wanted,
    )
