"""Diagnose and adopt in turn until nothing more is justified."""

import hashlib
import json
from collections.abc import Sequence
from pathlib import Path

from t2l.artefacts import read_json, read_text, reading, write_text
from t2l.diagnose.artefacts import write_diagnosis
from t2l.diagnose.backward_elimination import simplify
from t2l.diagnose.confounded import Confounded
from t2l.diagnose.evidence import Evidence, fine_enough
from t2l.diagnose.explanation import Explanation, Step
from t2l.diagnose.files import DIAGNOSIS, MODEL, STEPS
from t2l.diagnose.fingerprint import fingerprint_of
from t2l.diagnose.ranking import MISSING, Diagnosis, diagnose, telling, verdict_of
from t2l.diagnose.settings import MOST_EFFECTS
from t2l.diagnose.wording import ended
from t2l.errors import T2LError, writing
from t2l.identify.model import Model, read_again, write_model
from t2l.identify.progress import Progress, pieces
from t2l.identify.refit import refitted
from t2l.identify.scales import sized
from t2l.names import path_of
from t2l.typed import is_number

ERRORS = tuple(f"{part}_rmse_q_rad" for part in ("train", "validation", "test"))


def explain(
    model: Model,
    evidence: Evidence,
    folder: Path,
    progress: Progress = lambda what, fraction: None,
    beforehand: Sequence[Confounded] = (),
) -> Explanation:
    """Adopt the first-ranked effect as long as the verdict is `missing_effect`.

    An effect that is superfluous without its partner is taken back at once. A step that so leads
    back to effects that the model had before ends the search.

    Each step is kept in ``folder/steps/<n>`` with what it was made from, so that an interrupted
    run goes on with the step it was in.

    Args:
        beforehand: effects that the recordings do not tell apart, which are never certain.
    """
    evidence = telling(model, evidence)
    model = sized(model, evidence.train)
    steps, key, had = [], fingerprint(model, evidence), [_terms(model, evidence)]
    added, dropped, shares = (), [], ()
    for number, step in zip(range(MOST_EFFECTS + 1), pieces(progress), strict=False):
        where = folder / STEPS / str(number)
        content = _finished(where, key, model)
        if content is None:

            def told(what, fraction, number=number, step=step):
                step(f"step {number + 1}: {what}", fraction)

            content = _step(model, evidence, where, key, told, beforehand)
        else:
            step(f"step {number + 1}: kept from before", 1.0)
        baseline = content["baseline"]
        titles = _titles(model, added, evidence)
        errors = (baseline[key] for key in ERRORS)
        steps.append(Step(added, *errors, tuple(dropped), titles, shares))
        if content["verdict"] != MISSING or number == MOST_EFFECTS:
            break
        effect, share = (content["ranking"][0][key] for key in ("effect", "chosen_share"))
        added, shares = (effect,), (share,)
        grown, dropped = _adopted(model, effect, evidence, where, key)
        terms = _terms(grown, evidence)
        if terms in had:
            content = _nothing_stands(content, where)
            break
        model = grown
        had.append(terms)
        evidence = fine_enough(model, evidence)
        key = hashlib.sha256((key + effect).encode()).hexdigest()
    return Explanation(
        steps, content["verdict"], content["noise_floor_rad"], content["sentence"], model,
        beforehand=tuple(beforehand),
    )  # fmt: skip


def _adopted(
    model: Model, effect: str, evidence: Evidence, where: Path, key: str
) -> tuple[Model, list[str]]:
    """The model with `effect`, less what that made superfluous; kept with the step."""
    kept, record = where / MODEL, where / "adopted.json"
    found = _adopted_before(where, key, model)
    if found is not None:
        return found
    grown = read_again(_model_with(where, effect), model)
    found, dropped = simplify(grown, evidence) if model.effects else (grown, [])
    finer = fine_enough(found, evidence)
    if finer is not evidence:
        found = refitted(found, finer.train, finer.train_mask)
    write_model(found, kept, f"the model after {effect} was adopted")
    write_text(json.dumps({"fingerprint": key, "dropped": dropped}) + "\n", record)
    return read_again(kept, model), dropped


def _adopted_before(where: Path, key: str, model: Model) -> tuple[Model, list[str]] | None:
    """What `_adopted` kept of the same step; None if that is not there or not usable."""
    path = where / "adopted.json"
    try:
        record = read_json(path, "what was adopted", ("fingerprint", "dropped"))
        dropped = record["dropped"]
        if record["fingerprint"] != key or not isinstance(dropped, list):
            return None
        if not all(isinstance(name, str) for name in dropped):
            return None
        return read_again(where / MODEL, model), dropped
    except T2LError:
        return None


def _model_with(where: Path, effect: str) -> Path:
    return path_of(where / "models", effect, ".yaml")


def _step(model, evidence, where, key, progress, beforehand) -> dict:
    diagnosis: Diagnosis = diagnose(
        model, evidence, progress=progress, quick=True, beforehand=beforehand
    )
    with writing(where / "fingerprint"):
        (where / "fingerprint").unlink(missing_ok=True)
    content = write_diagnosis(diagnosis, evidence, where, beforehand)
    # last: its presence says that the step is whole
    write_text(key, where / "fingerprint")
    return content


def _terms(model: Model, evidence: Evidence) -> set:
    """What a model has, and on which joints: an effect may grow from one to more."""
    return {(term.effect.name, term.joints) for term in model.terms(evidence.train.joints)}


def _titles(model: Model, names: Sequence[str], evidence: Evidence) -> tuple[str, ...]:
    joints = evidence.train.joints
    terms = {term.effect.name: term for term in model.terms(joints)}
    known = model.known_effects()
    return tuple(terms[n].title(joints) if n in terms else known[n].title for n in names)


def _nothing_stands(content: dict, where: Path) -> dict:
    """A diagnosis whose first effect was taken back at once, kept as that."""
    errors, floor = content["baseline"], content["noise_floor_rad"]
    test, validation = (errors[f"{part}_rmse_q_rad"] for part in ("test", "validation"))
    verdict = verdict_of(validation, floor, justified=False)
    first, *rest = content["ranking"]
    why = f"{first['why']} But alone it was superfluous, and was taken back."
    content = content | {
        "verdict": verdict,
        "sentence": ended(verdict, test, validation, floor),
        "ranking": [first | {"justified": False, "why": why}, *rest],
    }
    write_text(json.dumps(content, indent=2) + "\n", where / DIAGNOSIS)
    return content


def _finished(where: Path, key: str, model: Model) -> dict | None:
    """What a step found; None if it is not there, of another step, or not usable."""
    path, keys = where / DIAGNOSIS, ("verdict", "sentence", "noise_floor_rad", "baseline")
    try:
        if read_text(where / "fingerprint", "a fingerprint") != key:
            return None
        content = read_json(path, "a diagnosis", (*keys, "ranking"))
        with reading(path, "a diagnosis"):
            errors = [content["baseline"][key] for key in ERRORS]
            if not all(map(is_number, (*errors, content["noise_floor_rad"]))):
                return None
            if not all(isinstance(content[key], str) for key in ("verdict", "sentence")):
                return None
            if content["verdict"] == MISSING:
                effect = content["ranking"][0]["effect"]
                share = content["ranking"][0]["chosen_share"]
                if share is not None and not is_number(share):
                    return None
                if effect not in read_again(_model_with(where, effect), model).effects:
                    return None
    except T2LError:
        return None
    return content


def fingerprint(model: Model, evidence: Evidence) -> str:
    """Of everything a diagnosis depends on."""
    predictors = (evidence.train, evidence.validation, evidence.test)
    return fingerprint_of(model, evidence.split, predictors)
