"""The proposal of an explanation: the one place where `t2l explain` calls for one."""

import hashlib
import json
import os
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

from t2l.artefacts import read_json, reading, write_text
from t2l.diagnose.evidence import Evidence, fine_enough
from t2l.diagnose.explanation import Explanation, Partial, as_json
from t2l.diagnose.files import MODEL, PARTIAL, PROPOSAL, PROPOSED
from t2l.diagnose.forward_selection import fingerprint
from t2l.diagnose.ranking import NOTHING_MISSING, UNEXPLAINED
from t2l.errors import T2LError, writing
from t2l.identify.levels import AT_THE_FLOOR
from t2l.identify.model import Model, read_again, write_model
from t2l.identify.progress import Progress
from t2l.propose.artefacts import write_proposal
from t2l.propose.proposal import LAW
from t2l.propose.reconsider import Reconsidered, reconsider
from t2l.propose.wording import headline, part_of_it, retracted

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
    before = _before(where, key, model)
    if before is not None:
        return replace(explanation, model=read_again(where / MODEL, model), **before)
    evidence = fine_enough(explanation.model, evidence)
    quiet = AT_THE_FLOOR * explanation.noise_floor_rad
    found = reconsider(model, explanation.model, evidence, quiet, progress)
    if found is None:
        # one of an earlier run
        if os.path.lexists(where / PROPOSAL):
            with writing(where):
                shutil.rmtree(where)
        return explanation
    return _kept(_said(explanation, found, model, evidence, where), where, key)


def _said(
    explanation: Explanation, found: Reconsidered, model: Model, evidence: Evidence, where: Path
) -> Explanation:
    """The explanation as what was found changes it; the proposal is written."""
    gone = {*found.dropped, *found.partial}
    known = [
        {"effect": name, "stands": name not in gone, "partial": name in found.partial}
        for name in explanation.model.effects
        if name not in model.effects
    ]
    train, validation = evidence.train, evidence.validation
    judged = (train, evidence.train_mask), (validation, evidence.validation_mask)
    # sentences stand side by side: all quote the noise of one set of recordings
    quoted = replace(found.proposal, noise_floor_rad=explanation.noise_floor_rad)
    told = replace(found, proposal=quoted)
    sentence = retracted(told) if found.dropped else headline(quoted)
    sentence = part_of_it(told) if found.partial else sentence
    content = write_proposal(
        found.proposal, where, judged, evidence.test, known, sentence, evidence.test_mask
    )
    sentence = content["sentence"]
    if found.partial:
        names = explanation.model
        partial = Partial(found.partial, found.explained, found.names_rmse_rad, names)
        changed = {"model": found.model, "verdict": UNEXPLAINED, "sentence": sentence}
        return replace(explanation, **changed, partial=partial)
    if found.proposal.verdict != LAW:
        return explanation
    if not found.dropped:
        before = explanation.sentence
        if explanation.verdict == NOTHING_MISSING:
            before = "Known effects explain nearly all, but not all."
        sentence = f"{before} {sentence}"
    return replace(explanation, model=found.model, verdict=UNEXPLAINED, sentence=sentence)


def _key(model: Model, explanation: Explanation, evidence: Evidence) -> str:
    """Of everything that a proposal depends on."""
    text = fingerprint(model, evidence) + repr((explanation.model, explanation.noise_floor_rad))
    return hashlib.sha256(text.encode()).hexdigest()


def _before(where: Path, key: str, model: Model) -> dict[str, Any] | None:
    """What an earlier run of the same found; None if there is none, or it is not whole."""
    keys = ("fingerprint", "verdict", "sentence", "partial")
    try:
        record = read_json(where / RECORD, "a record", keys)
        whole = os.path.lexists(where / PROPOSAL) and record["fingerprint"] == key
        read_again(where / MODEL, model)
        with reading(where / RECORD, "a record"):
            partial = record["partial"] and Partial(
                tuple(record["partial"]["effects"]),
                float(record["partial"]["explained_fraction"]),
                float(record["partial"]["test_rmse_q_rad"]),
                read_again(where / PARTIAL, model),
            )
    except T2LError:
        return None
    texts = {name: record[name] for name in ("verdict", "sentence")}
    if not whole or not all(isinstance(t, str) for t in texts.values()):
        return None
    return {**texts, "partial": partial}


def _kept(explanation: Explanation, where: Path, key: str) -> Explanation:
    """The explanation as its files have it, so that a second run need not do the same again."""
    write_model(explanation.model, where / MODEL, "the model as t2l explain leaves it")
    partial = explanation.partial
    if partial:
        comment = f"not adopted, as they explain only a part: {', '.join(partial.effects)}"
        write_model(partial.model, where / PARTIAL, comment)
        partial = replace(partial, model=read_again(where / PARTIAL, explanation.model))
    else:
        with writing(where / PARTIAL):
            (where / PARTIAL).unlink(missing_ok=True)
    content = as_json(explanation)
    said = {name: content[name] for name in ("verdict", "sentence", "partial")}
    write_text(json.dumps({"fingerprint": key, **said}) + "\n", where / RECORD)
    kept = read_again(where / MODEL, explanation.model)
    return replace(explanation, model=kept, partial=partial)
