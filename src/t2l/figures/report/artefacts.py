"""What `t2l compare`, `diagnose` and `explain` left in a folder."""

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from t2l.discrepancy.traces import Traces, read_traces
from t2l.errors import ArtefactError

COMPARISON, DIAGNOSIS, EXPLANATION = "comparison.json", "diagnosis.json", "explanation.json"


@dataclass(frozen=True)
class Compared:
    """A model's comparison: its numbers, its samples, and what to call the model."""

    label: str
    numbers: dict[str, Any]
    traces: Traces


@dataclass(frozen=True)
class Step:
    """A diagnosis on the way, and the effect adopted after it (None after the last)."""

    diagnosis: dict[str, Any]
    adopted: str | None


@dataclass(frozen=True)
class Found:
    """Everything a page may tell.

    Attributes:
        compared: one model, or the one that came and the final one; may be empty.
        steps: diagnoses in order; may be empty.
        explanation: content of explanation.json.
        model_yaml: the final model as text.
    """

    compared: list[Compared] = field(default_factory=list)
    steps: list[Step] = field(default_factory=list)
    explanation: dict[str, Any] | None = None
    model_yaml: str | None = None

    @property
    def heldout(self) -> set[str]:
        """Names of the recordings that were held out as a whole."""
        if not self.steps:
            return set()
        first = self.steps[0].diagnosis
        held = set(first.get("heldout_recordings", []))
        return held - set(first.get("training_recordings", []))


def read_found(folder: Path | str) -> Found:
    """Read a folder.

    Raises:
        ArtefactError: it holds nothing to tell, or a file is malformed.
    """
    folder = Path(folder)
    if (folder / EXPLANATION).is_file():
        return _explained(folder)
    if (folder / DIAGNOSIS).is_file():
        return Found(steps=[Step(_json(folder / DIAGNOSIS), None)])
    if (folder / COMPARISON).is_file():
        return Found(compared=[_compared(folder, "model")])
    raise ArtefactError(
        folder, "nothing to report", f"one of {EXPLANATION}, {DIAGNOSIS}, {COMPARISON} in it"
    )


def _explained(folder: Path) -> Found:
    explanation = _json(folder / EXPLANATION)
    effects = [step["effect"] for step in explanation["steps"]]
    steps = []
    for number, adopted in enumerate([*effects[1:], None]):
        path = folder / "steps" / str(number) / DIAGNOSIS
        if path.is_file():
            steps.append(Step(_json(path), adopted))
    compared = [
        _compared(folder / name, label)
        for name, label in (("before", "model as it came"), ("after", "final model"))
        if (folder / name / COMPARISON).is_file()
    ]
    if len(compared) == 2 and len(compared[0].traces.joint) != len(compared[1].traces.joint):
        raise ArtefactError(folder, "before and after are of different recordings", "the same")
    model = folder / "model.yaml"
    return Found(compared, steps, explanation, model.read_text() if model.is_file() else None)


def _compared(folder: Path, label: str) -> Compared:
    return Compared(label, _json(folder / COMPARISON), read_traces(folder))


def _json(path: Path) -> dict[str, Any]:
    try:
        return json.loads(path.read_text())
    except json.JSONDecodeError as error:
        raise ArtefactError(path, f"cannot be read as JSON ({error})", "a JSON object") from None
