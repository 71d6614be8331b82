"""What a proposal leaves in a folder.

proposal.json            verdict, curves with bands, formulas, what each law could explain
models/NAME.yaml         the model with a curve, or a formula, adopted
"""

import json
import os
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from t2l.artefacts import read_json, reading, write_text
from t2l.diagnose.files import PROPOSAL
from t2l.effects.formula import Constant, FormulaLaw
from t2l.effects.law import INERTIA, TENDON, Law
from t2l.errors import ArtefactError, writing
from t2l.identify.model import Model, write_model
from t2l.identify.prediction import Predictor
from t2l.names import is_plain, path_of
from t2l.propose.expression import Formula
from t2l.propose.formula import installed
from t2l.propose.formula_fit import Sets, formulas_of
from t2l.propose.proposal import Learned, Proposal, error_of
from t2l.propose.wording import as_formulas, headline, told, variable

BOUND = 10.0  # bound: times a constant: as far as later fits may move it
CEILINGS = 12  # format: told of
MISSING = "no formula was searched: pyoperon is not installed; allowed: pip install 't2l[propose]'"


def write_proposal(
    proposal: Proposal,
    folder: Path,
    judged: Sets,
    report: Predictor | None = None,
    sentence: str = "",
    report_mask: np.ndarray | None = None,
) -> dict[str, Any]:
    """Write all of it, proposal.json last; what it holds is returned.

    Args:
        judged: predictors, and the samples of each that formulas are fitted to and judged by: one
            must explain them nearly as well as its curve.
        report: of recordings that neither fitted nor chose, on which formulas are reported.
        sentence: what was found; by default as if nothing but the model came before. What formulas
            leave is added.
        report_mask: (nsample,) bool of `report`, the samples that report; by default all.
    """
    _remove_before(folder)
    found = formulas_of(proposal, judged)

    def reported(model: Model) -> float | None:
        """None too where a formula runs away."""
        left = np.nan if report is None else error_of(model, report, report_mask)
        return left if np.isfinite(left) else None

    curves = [
        _written(proposal, one, found.get(one.curve.law), folder, reported)
        for one in proposal.learned
    ]
    in_words = None
    if any(curve["formula"] for curve in curves):
        in_words = reported(_with_all_formulas(proposal, found))
    content = {
        "verdict": proposal.verdict,
        "sentence": (sentence or headline(proposal)) + as_formulas(proposal, in_words),
        "noise_floor_rad": proposal.noise_floor_rad,
        "choice": {
            "baseline_rmse_q_rad": proposal.choice_baseline_rad,
            "rmse_q_rad": proposal.choice_rmse_rad,
        },
        "report": {
            "baseline_rmse_q_rad": proposal.report_baseline_rad,
            "rmse_q_rad": proposal.report_rmse_rad,
            # each law as its formula if it has one
            "formulas_rmse_q_rad": in_words,
            "recordings": list(proposal.reported),
        },
        "fitted_recordings": list(proposal.fitted),
        "curves": curves,
        "ceilings": [
            {
                "law": c.law.words,
                "kind": c.law.kind,
                "joint": c.law.joint,
                "follows": c.law.follows,
                "of": c.law.of,
                "rmse_q_rad": c.rmse_rad,
            }
            for c in proposal.ceilings[:CEILINGS]
        ],
    }
    write_text(json.dumps(content, indent=2) + "\n", folder / PROPOSAL)
    return content


def _remove_before(folder: Path) -> None:
    """Remove an earlier proposal and what it names."""
    try:
        names = proposed(folder)
    except ArtefactError:
        names = []
    with writing(folder / PROPOSAL):
        (folder / PROPOSAL).unlink(missing_ok=True)
    for name in names:
        path = path_of(folder / "models", name, ".yaml")
        with writing(path):
            path.unlink(missing_ok=True)


def _written(
    proposal: Proposal,
    one: Learned,
    found: Formula | None,
    folder: Path,
    reported: Callable[[Model], float | None],
) -> dict[str, Any]:
    law = one.curve.law
    name = plain_name(law)
    comment = f"the model so far with {law.words}, as t2l propose learned it"
    write_model(proposal.with_some([law]), path_of(folder / "models", name, ".yaml"), comment)
    content = {
        "name": name,
        "law": told(one.curve),
        "kind": law.kind,
        "joint": law.joint,
        "follows": law.follows,
        "of": law.of,
        "variable": variable(one.curve),
        "ratio": one.curve.ratio if law.kind == TENDON else None,
        "unit": law.unit,
        "at": list(one.curve.at),
        "torque": list(one.curve.torque),
        "low": one.low.tolist(),
        "high": one.high.tolist(),
        "formula": None,
        "note": "",
    }
    if law.kind == INERTIA:
        return content | {"note": f"an inertia of {one.curve.inertia:.3g} kg·m²"}
    if not installed():
        return content | {"note": MISSING}
    if found is None:
        return content | {"note": "no short formula fits within the band"}
    return content | {"formula": _formula(proposal, one, found, folder, reported)}


def plain_name(law: Law) -> str:
    """A curve's name as a file's."""
    return law.plain_name("learned")


def _formula(
    proposal: Proposal,
    one: Learned,
    found: Formula,
    folder: Path,
    reported: Callable[[Model], float | None],
) -> dict[str, Any]:
    law = one.curve.law
    formula = formula_law(law, found, one.curve.ratio)
    alone = with_formula(proposal.model, formula, found.values)
    comment = f"the model so far with a formula of {law.words}"
    write_model(alone, path_of(folder / "models", formula.name, ".yaml"), comment)
    return {
        "effect": formula.name,
        "sentence": found.sentence(),
        "text": found.text,
        "values": found.values,
        "units": found.units,
        "report_rmse_q_rad": reported(with_formula(proposal.without(one), formula, found.values)),
    }


def _with_all_formulas(proposal: Proposal, found: Mapping[Law, Formula]) -> Model:
    """The model with all that was learned, each law as its formula if it has one."""
    model = proposal.with_some(
        [one.curve.law for one in proposal.learned if one.curve.law not in found]
    )
    for one in proposal.learned:
        if formula := found.get(one.curve.law):
            law = formula_law(one.curve.law, formula, one.curve.ratio)
            model = with_formula(model, law, formula.values)
    return model


def formula_law(law: Law, found: Formula, ratio: float = 0.0) -> FormulaLaw:
    """A formula that was found as one of a model; `ratio` of a tendon, as of its curve."""
    reach = {name: BOUND * abs(value) + 1e-6 for name, value in found.values.items()}
    constants = {name: Constant(found.units[name], -most, most) for name, most in reach.items()}
    return FormulaLaw(law, found.text, constants, ratio)


def with_formula(model: Model, formula: FormulaLaw, constants: Mapping[str, float]) -> Model:
    """A model with a formula at values of its constants."""
    alone = formula.law.kind == TENDON
    values = {
        name: float(value) if alone else {formula.law.joint: float(value)}
        for name, value in constants.items()
    }
    others = (one for one in model.formulas if one.name != formula.name)
    effects = {**model.effects, formula.name: values}
    return replace(model, effects=effects, formulas=(*others, formula))


def proposed(folder: Path) -> list[str]:
    """Names of the curves and formulas that a folder proposes; none where there is no proposal.

    Raises:
        ArtefactError: its file is no proposal.
    """
    path = folder / PROPOSAL
    if not os.path.lexists(path):
        return []
    content = read_json(path, "a proposal", ("curves",))
    with reading(path, "a proposal with a list of curves"):
        names = [str(curve["name"]) for curve in content["curves"]]
        names += [str(c["formula"]["effect"]) for c in content["curves"] if c["formula"]]
    return [name for name in names if is_plain(name)]
