"""What physics alone leaves: hidden effects fitted from their true numbers.

`python -m benchmarks from_truth [--robots N | --test-seed N] [--processes N] [CASE ...]`: no effect
is searched and no first guess is needed. An error above the noise is then of what t2l's effects say
otherwise than the generator's, or of numbers that the recordings do not tell. Beside it stands what
they leave along the measured motion, with the loop linearised at the model as it came, as a search
sees it in its first round; empty for effects with a state of their own. Cases with an effect that
has no such numbers in t2l are left out.
"""

import argparse
from collections.abc import Sequence

import numpy as np
import pandas as pd
import yaml

from benchmarks import one_core
from benchmarks.hidden import FOLDER, PROCESSES, is_known, snake
from benchmarks.hidden_effects.__main__ import write_case
from benchmarks.hidden_effects.as_t2l import numbers
from benchmarks.hidden_effects.cases import Case, cases
from benchmarks.hidden_effects.drawn_robots import cases_on_robots

ITERATIONS = 8  # numerics: of least squares


def main(arguments: Sequence[str]) -> pd.DataFrame:
    """What the command line asks for: a row a case, errors in mrad."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks from_truth", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="CASE", help="cases (default: all)")
    one_core.add_processes(parser, PROCESSES)
    seeds = parser.add_mutually_exclusive_group()
    seeds.add_argument("--test-seed", type=int, metavar="N", help="the set drawn from this number")
    seeds.add_argument("--robots", type=int, metavar="N", help="the same over more robots")
    given = parser.parse_args(arguments)
    drawn = cases(given.test_seed) if given.robots is None else cases_on_robots(given.robots)
    chosen = [c for c in drawn if is_known(c) and (not given.names or c.name in given.names)]
    rows = []
    for row in one_core.each(left_from_truth, chosen, given.processes):
        if row is not None:
            rows.append(row)
            print(f"{row['case']}: {row['after']:.4f} mrad, noise {row['noise']:.4f}", flush=True)
    return pd.DataFrame(rows)


def left_from_truth(case: Case) -> dict | None:
    """RMS errors of fitted samples at the true numbers and after fits from there, mrad."""
    # here, so that listing cases does not import the simulator in the parent
    from t2l.detective.data_split import split
    from t2l.detective.fitted_set import Start, sizes
    from t2l.diagnose.recordings_and_model import read_recordings_and_model
    from t2l.identify.fitting import PositionError
    from t2l.identify.least_squares import LeastSquares
    from t2l.identify.optimiser import minimise
    from t2l.identify.scales import sized
    from t2l.identify.step_size import substeps_for

    folder = FOLDER / "cases" / case.name
    write_case(case, folder.parent)
    truth = yaml.safe_load((folder / "truth.yaml").read_text())
    model, recordings, held = read_recordings_and_model([folder / "train"], [folder / "holdout"])
    data = split(model.robot, recordings, held, substeps_for(model, recordings), threads=1)
    model = sized(model, data.fitted)
    true = true_numbers(truth["hidden"], model, data.fitted.joints)
    if true is None:
        return None
    layout, u = true
    setup = truth["setup"]
    # a rounded number is off by its step over √12
    noise = float(
        np.hypot(setup["encoder_noise_rad"], setup["encoder_resolution_rad"] / np.sqrt(12))
    )
    fit = LeastSquares(layout, u, sizes(Start(layout, u)), noise=noise)
    objective = PositionError(data.fitted, data.fitted_mask)
    minimise([fit], objective, 0)
    before = fit.loss**0.5
    minimise([fit], objective, ITERATIONS)
    after = fit.loss**0.5
    along = _along(model, data, layout, u, noise)
    return {
        "case": case.name,
        "hidden": " ".join(snake(entry["effect"]) for entry in truth["hidden"]),
        "noise": 1e3 * noise,
        "before": 1e3 * before,
        "after": 1e3 * after,
        "along": 1e3 * along,
        "times the noise": after / noise,
        "along, times": along / noise,
    }


def _along(model, data, layout, u: np.ndarray, noise: float) -> float:
    """RMS error, rad, of a fit along the motion, from u (n,); NaN of what can only be simulated."""
    from t2l.detective.along_motion import AlongMotion, fit_along
    from t2l.detective.fit import Samples, fit_sets
    from t2l.detective.fitted_set import Start
    from t2l.detective.linear_loop import linearised
    from t2l.detective.motion import measured_motion

    fitted, mask, folds = data.fitted, data.fitted_mask, data.folds
    start = Start(*model.vector(fitted.joints))
    (came,) = fit_sets([start], Samples(fitted, fitted, fitted, mask, folds), iterations=0)
    linear = Samples.of(fitted, mask, folds, came.model, noise).linear
    sections = linearised(linear, *came.model, measured_motion(linear, *came.model))
    along = AlongMotion(linear, sections, mask, came.known, noise)
    return min((one.rmse for one in fit_along([Start(layout, u)], along, folds)), default=np.nan)


def true_numbers(hidden: Sequence[dict], model, joints: tuple[str, ...]):
    """Layout and u (n,) of t2l's effects at the hidden numbers; None where one has no such form."""
    from t2l.effects.link_inertia import _links
    from t2l.effects.term import Layout, Term
    from t2l.robots import plant

    known = model.known_effects(joints)
    bare = plant.load(model.robot, list(joints)).compile()
    moved = _links(bare, joints, np.arange(len(joints)))
    links = {joint: bare.body(body).name for joint, body in zip(joints, moved, strict=True)}
    terms, values = [], {}
    for entry in hidden:
        name = snake(entry["effect"])
        given = numbers(entry, joints, links) if name in known else None
        if given is None:
            return None
        by_joint = {j for value in given.values() if isinstance(value, dict) for j in value}
        on = [i for i, joint in enumerate(joints) if not by_joint or joint in by_joint]
        terms.append(Term(known[name], tuple(on)))
        values[name] = {
            p.name: _values(p, given.get(p.name), joints, on) for p in known[name].parameters
        }
    layout = Layout(terms)
    return layout, np.clip(layout.encode(values), layout.lower, layout.upper)


def _values(parameter, given, joints: Sequence[str], on: Sequence[int]) -> np.ndarray:
    """One for each joint, or one for all; what is not hidden is neutral, or zero."""
    absent = parameter.neutral if np.isfinite(parameter.neutral) else 0.0
    if not parameter.per_joint:
        given = next(iter(given.values())) if isinstance(given, dict) else given
        return np.array([absent if given is None else float(given)])
    each = given if isinstance(given, dict) else dict.fromkeys(joints, given)
    found = [absent if each.get(joints[i]) is None else float(each[joints[i]]) for i in on]
    if not parameter.log:
        return np.array(found)
    # what is neutral without bound is at the bound
    upper = np.broadcast_to(parameter.upper, len(joints))[on]
    return np.where(np.array(found) > 0, found, upper)
