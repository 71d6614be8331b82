"""The proposal of an explanation: the one place where `t2l explain` calls for one."""

import hashlib
import json
import os
import shutil
from dataclasses import replace
from pathlib import Path

from t2l.artefacts import read_json, write_text
from t2l.diagnose.evidence import Evidence, fine_enough
from t2l.diagnose.files import MODEL, PROPOSAL, PROPOSED
from t2l.diagnose.forward_selection import Explanation, fingerprint
from t2l.diagnose.ranking import NOTHING_MISSING, UNEXPLAINED
from t2l.errors import T2LError, writing
from t2l.identify.levels import AT_THE_FLOOR, SHORTLISTED
from t2l.identify.model import Model, read_model, write_model
from t2l.propose.artefacts import write_proposal
from t2l.propose.proposal import LAW
from t2l.propose.reconsider import reconsider
from t2l.propose.search import Progress
from t2l.propose.split import few, split
from t2l.propose.wording import headline, retracted

RECORD = "beside.json"


def proposed_beside(
    model: Model,
    explanation: Explanation,
    evidence: Evidence,
    folder: Path,
    progress: Progress = lambda what, fraction: None,
) -> Explanation:
    """The explanation with the names that stand; what they leave is proposed in a folder.

    Args:
        model: as it came.

    Raises:
        DivergenceError: a simulation of the model runs away.
    """
    where, key = folder / PROPOSED, _key(model, explanation, evidence)
    before = _before(where, key)
    if before is not None:
        kept = read_model(where / MODEL, model.without)
        return replace(explanation, model=kept, **before)
    evidence = fine_enough(explanation.model, evidence)
    quiet = AT_THE_FLOOR * explanation.noise_floor_rad
    found = reconsider(model, explanation.model, evidence, quiet, progress)
    if found is None:
        # one of an earlier run
        if os.path.lexists(where / PROPOSAL):
            with writing(where):
                shutil.rmtree(where)
        return explanation
    known = [
        {"effect": name, "stands": name not in found.dropped}
        for name in explanation.model.effects
        if name not in model.effects
    ]
    predictor, at = few(evidence.train, SHORTLISTED)
    chosen = predictor, split(predictor)[1] & evidence.train_mask[at]
    sentence = retracted(found) if found.dropped else headline(found.proposal)
    write_proposal(found.proposal, where, chosen, evidence.test, known, sentence)
    if found.proposal.verdict != LAW:
        return _kept(explanation, where, key)
    if not found.dropped:
        before = explanation.sentence
        if explanation.verdict == NOTHING_MISSING:
            before = "Known effects explain nearly all, but not all."
        sentence = f"{before} {sentence}"
    changed = replace(explanation, model=found.model, verdict=UNEXPLAINED, sentence=sentence)
    return _kept(changed, where, key)


def _key(model: Model, explanation: Explanation, evidence: Evidence) -> str:
    """Of everything that a proposal depends on."""
    text = fingerprint(model, evidence) + repr((explanation.model, explanation.noise_floor_rad))
    return hashlib.sha256(text.encode()).hexdigest()


def _before(where: Path, key: str) -> dict[str, str] | None:
    """What an earlier run of the same found; None if there is none, or it is not whole."""
    try:
        record = read_json(where / RECORD, "a record", ("fingerprint", "verdict", "sentence"))
        whole = os.path.lexists(where / PROPOSAL) and record["fingerprint"] == key
        read_model(where / MODEL)
    except T2LError:
        return None
    texts = {name: record[name] for name in ("verdict", "sentence")}
    return texts if whole and all(isinstance(t, str) for t in texts.values()) else None


def _kept(explanation: Explanation, where: Path, key: str) -> Explanation:
    """The explanation as its files have it, so that a second run need not do the same again."""
    write_model(explanation.model, where / MODEL, "the model as t2l explain leaves it")
    record = {"fingerprint": key, "verdict": explanation.verdict, "sentence": explanation.sentence}
    write_text(json.dumps(record) + "\n", where / RECORD)
    kept = read_model(where / MODEL, explanation.model.without)
    return replace(explanation, model=kept)
