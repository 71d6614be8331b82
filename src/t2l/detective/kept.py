"""What a search leaves in its folder after each round, for the same search to go on from.

``steps/<n>/model.yaml`` is the model after step n, and ``steps/fitted.npz`` the last of them with
its residuals and derivatives, which are all that the next round needs.
"""

import dataclasses
import json
import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from t2l.artefacts import read_npz, reading, remove, whole
from t2l.detective.fitted_set import FittedSet
from t2l.diagnose.explanation import Explanation, Step, Tried, write_explanation
from t2l.diagnose.files import AFTER, BEFORE, FIGURES, MODEL, PROPOSED, REPORT, STEPS
from t2l.effects.effect import Effect
from t2l.effects.law import Law
from t2l.effects.spline_torque import SplineTorque
from t2l.effects.term import Layout, Term
from t2l.errors import T2LError, writing
from t2l.identify.model import Model, write_model

FITTED = "fitted.npz"
ARRAYS = ("u", "residual", "left_out", "told", "jacobian", "free")


def keep_step(
    explanation: Explanation,
    parameters: Sequence[dict],
    came: Model,
    folder: Path,
) -> None:
    """Write the explanation so far, and the model of its last step.

    Args:
        parameters: of that model.
        came: the model as it came.
    """
    number = len(explanation.steps) - 1
    with writing(folder):
        # of an earlier run, or of the model before
        for name in (BEFORE, AFTER, FIGURES, PROPOSED, REPORT):
            remove(folder / name)
        for path in _later(folder, number):
            remove(path)
    models = {number: explanation.model} if number > 1 else {0: came, number: explanation.model}
    for n, model in models.items():
        comment = f"the model after step {n}" if n else "the model as it came"
        write_model(model, folder / STEPS / str(n) / MODEL, comment)
    write_explanation(explanation, folder, parameters)


def _later(folder: Path, number: int) -> list[Path]:
    """What an earlier run left, of as many steps or more."""
    steps = folder / STEPS
    if number < 2:
        return [steps]
    names = os.listdir(steps) if steps.is_dir() else []
    return [steps / name for name in names if name.isdecimal() and int(name) >= number]


def keep_fitted(
    folder: Path, key: str, steps: Sequence[Step], rounds: int, last: FittedSet
) -> None:
    """Write what `fitted_before` reads.

    Args:
        key: fingerprint of what the search depends on.
        rounds: that led to the steps.
    """
    terms = [[t.effect.name, t.joints, _as_text(t.effect)] for t in last.layout.terms]
    texts = {
        "key": key,
        "rounds": rounds,
        "steps": json.dumps([dataclasses.asdict(step) for step in steps]),
        "terms": json.dumps(terms),
        "phases": last.phases,
    }
    with whole(folder / STEPS / FITTED) as draft:
        np.savez(draft, **texts, **{name: getattr(last, name) for name in ARRAYS})


def fitted_before(
    folder: Path, key: str, model: Model, joints: tuple[str, ...]
) -> tuple[list[Step], int, FittedSet] | None:
    """Steps and rounds of an interrupted search, what it adopted last; None if it was another."""
    path = folder / STEPS / FITTED
    try:
        arrays = read_npz(path, ("key", "rounds", "steps", "terms", "phases", *ARRAYS))
        if str(arrays["key"]) != key:
            return None
        known = model.known_effects(joints) | {
            term.effect.name: term.effect for term in model.terms(joints)
        }
        with reading(path, "the last step of a search"):
            rounds = int(arrays["rounds"])
            steps = [_step(entry) for entry in json.loads(str(arrays["steps"]))]
            terms = [
                Term(_spline(curve) if curve else known[name], tuple(on))
                for name, on, curve in json.loads(str(arrays["terms"]))
            ]
            own = {name: arrays[name] for name in ARRAYS}
            last = FittedSet(Layout(terms), **own, phases=int(arrays["phases"]))
            n, m = len(last.residual), len(last.layout.slots)
            shapes = [getattr(last, name).shape for name in ARRAYS]
            if shapes != [(m,), (n,), (n,), (n,), (n, m), (m,)]:
                return None
    except T2LError:
        return None
    return steps, rounds, last


def _as_text(effect: Effect) -> dict | None:
    """What makes a spline again; None of other effects."""
    if not isinstance(effect, SplineTorque):
        return None
    return {"law": dataclasses.asdict(effect.law)} | {
        name: value.tolist() if isinstance(value, np.ndarray) else value
        for name, value in effect.made_of().items()
    }


def _spline(text: dict) -> SplineTorque:
    arrays = {
        name: np.array(value) if isinstance(value, list) and name != "shown" else value
        for name, value in text.items()
    }
    return SplineTorque(**arrays | {"law": Law(**text["law"]), "shown": tuple(text["shown"])})


def _step(entry: dict) -> Step:
    lists = {name: tuple(value) for name, value in entry.items() if isinstance(value, list)}
    tried = tuple(Tried(**one | {"titles": tuple(one["titles"])}) for one in entry["tried"])
    return Step(**entry | lists | {"tried": tried})
