"""What `t2l compare`, `diagnose` and `explain` left in a folder."""

import os
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from t2l.artefacts import read_text
from t2l.diagnose import result_types
from t2l.diagnose.conditions import CONDITIONS
from t2l.diagnose.files import (
    AFTER,
    BEFORE,
    COMPARISON,
    DIAGNOSIS,
    EXPLANATION,
    MODEL,
    PROPOSAL,
    PROPOSED,
    STEPS,
    TRACES,
)
from t2l.diagnose.result_types import read_content
from t2l.diagnose.traces import Traces, read_traces
from t2l.effects.registry import builtin
from t2l.errors import ArtefactError
from t2l.names import listed


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
    """Everything that a figure or a page may tell.

    Attributes:
        compared: one model, or the one that came and the final one; may be empty.
        steps: diagnoses in order; may be empty.
        explanation: content of explanation.json.
        model_yaml: the final model as text.
        proposal: content of proposal.json.
    """

    compared: list[Compared] = field(default_factory=list)
    steps: list[Step] = field(default_factory=list)
    explanation: dict[str, Any] | None = None
    model_yaml: str | None = None
    proposal: dict[str, Any] | None = None

    @property
    def added(self) -> list[dict[str, Any]]:
        """What the steps of an explanation added and no later one dropped.

        Of each effect its name, its title with joints, and in how many resamples it was chosen.
        """
        kept: list[dict[str, Any]] = []
        for step in self.explanation["steps"] if self.explanation else []:
            kept = [one for one in kept if one["effect"] not in step["dropped"]]
            parts = (step[key] for key in ("effects", "titles", "chosen_shares"))
            kept += [
                {"effect": name, "title": title, "chosen_share": share}
                for name, title, share in zip(*parts, strict=True)
            ]
        return kept

    @property
    def dropped(self) -> list[str]:
        """Effects that were adopted and then gave way to learned curves."""
        known = self.proposal["known"] if self.proposal else []
        gone = [name["effect"] for name in known if not name["stands"]]
        return [] if self.partial else gone

    @property
    def partial(self) -> dict[str, Any] | None:
        """Effects that explain too little to be adopted, if there are any."""
        return self.explanation.get("partial") if self.explanation else None

    @property
    def untold(self) -> dict[str, list[dict[str, Any]]]:
        """By name of an adopted effect: what the recordings cannot tell it from."""
        confounded = (self.explanation or {}).get("confounded", {"names": []})
        return {entry["effect"]: entry["not_told_from"] for entry in confounded["names"]}

    @property
    def uses(self) -> dict[str, str]:
        """What recordings were used for as a whole, by name: "validation" or "test"."""
        if not self.steps:
            return {}
        first = self.steps[0].diagnosis
        trained = set(first.get("training_recordings", []))
        return {
            name: use
            for use in ("validation", "test")
            for name in first.get(f"{use}_recordings", [])
            if name not in trained
        }


def read_found(folder: Path | str) -> Found:
    """Read a folder.

    Raises:
        ArtefactError: it holds nothing to tell, or a file is malformed.
    """
    folder = Path(folder)
    if os.path.lexists(folder / EXPLANATION):
        return _explained(folder)
    if os.path.lexists(folder / DIAGNOSIS):
        return Found(steps=[Step(_diagnosis(folder), None)])
    if os.path.lexists(folder / PROPOSAL):
        return Found(proposal=_proposal(folder))
    if os.path.lexists(folder / COMPARISON):
        return Found(compared=[_compared(folder, "model")])
    raise ArtefactError(
        folder / EXPLANATION, "nothing to report", f"it, {DIAGNOSIS} or {COMPARISON} there"
    )


def _explained(folder: Path) -> Found:
    path = folder / EXPLANATION
    explanation = read_content(path, result_types.Explanation, "an explanation")
    if not explanation["steps"]:
        raise ArtefactError(path, "no steps", "the model as it came as the first")
    for number, step in enumerate(explanation["steps"]):
        if len({len(step[key]) for key in ("effects", "titles", "chosen_shares")}) > 1:
            found = f"steps.{number}: lists of several lengths"
            raise ArtefactError(path, found, "a title and a share of each effect")
    effects = [next(iter(step["effects"]), None) for step in explanation["steps"]]
    steps = []
    for number, adopted in enumerate([*effects[1:], None]):
        where = folder / STEPS / str(number)
        if os.path.lexists(where / DIAGNOSIS):
            steps.append(Step(_diagnosis(where), adopted))
    final = "with effects that explain a part" if explanation.get("partial") else "final model"
    compared = [
        _compared(folder / name, label)
        for name, label in ((BEFORE, "model as it came"), (AFTER, final))
        if os.path.lexists(folder / name / COMPARISON)
    ]
    if len(compared) == 2 and not _alike(*compared):
        found = "other recordings than those of the model as it came"
        raise ArtefactError(folder / AFTER / TRACES, found, "the same")
    model = folder / MODEL
    text = read_text(model, "a model") if os.path.lexists(model) else None
    return Found(compared, steps, explanation, text, _proposal(folder / PROPOSED))


def _alike(first: Compared, second: Compared) -> bool:
    return (
        len(first.traces.joint) == len(second.traces.joint)
        and first.traces.joints == second.traces.joints
        and first.traces.recordings == second.traces.recordings
    )


def _diagnosis(folder: Path) -> dict[str, Any]:
    path = folder / DIAGNOSIS
    content = read_content(path, result_types.Diagnosis, "a diagnosis")
    if content["verdict"] == "missing_effect" and not content["ranking"]:
        raise ArtefactError(path, "ranking: nothing", "the effect that is missing")
    return content


def _proposal(folder: Path) -> dict[str, Any] | None:
    path = folder / PROPOSAL
    if not os.path.lexists(path):
        return None
    content = read_content(path, result_types.Proposal, "a proposal")
    for i, curve in enumerate(content["curves"]):
        if len({len(curve[key]) for key in ("at", "torque", "low", "high")}) > 1:
            raise ArtefactError(path, f"curves.{i}: lists of several lengths", "one length")
    return content


def _compared(folder: Path, label: str) -> Compared:
    path = folder / COMPARISON
    numbers = read_content(path, result_types.Comparison, "a comparison")
    traces = read_traces(folder)
    # whether all is the same is no column
    missing = set(CONDITIONS) - set(traces.columns) - {"constant"}
    if missing:
        raise ArtefactError(folder / TRACES, f"lacks column {', '.join(sorted(missing))}", "all")
    known = set(traces.joints)
    named = {cell["joint"] for cell in numbers["cells"]} - {None}
    if known != set(numbers["joints"]) or not named <= known:
        raise ArtefactError(path, f"joints {', '.join(numbers['joints'])}", f"those of {TRACES}")
    if len(numbers["logs"]) != len(traces.recordings):
        expected = f"the {len(traces.recordings)} of {TRACES}"
        raise ArtefactError(path, f"{len(numbers['logs'])} recordings", expected)
    if any(len(log["kp"]) == 0 or len(log["kd"]) == 0 for log in numbers["logs"]):
        raise ArtefactError(path, "a recording without gains", "kp and kd of each")
    return Compared(label, numbers, traces)


def titles_of(found: Found) -> dict[str, str]:
    """Titles of effects by name: of this package's, and of those in the rankings."""
    return {name: effect.title for name, effect in builtin().items()} | {
        entry["effect"]: entry["title"]
        for step in found.steps
        for entry in step.diagnosis["ranking"]
    }


def errors_by_step(found: Found) -> list[tuple[str, float | None, float]]:
    """Label, training and test error in rad of the steps of an explanation.

    The model as it came, every known effect, and what was learned, of which there are no training
    errors.
    """
    first, *rest = found.explanation["steps"]
    labels = ["model as it came", *(_label(step, titles_of(found)) for step in rest)]
    errors = [(s["train_rmse_q_rad"], s["test_rmse_q_rad"]) for s in (first, *rest)]
    steps = [(label, *both) for label, both in zip(labels, errors, strict=True)]
    if not found.proposal or not found.proposal["curves"]:
        return steps
    curves = "curves instead" if found.dropped or found.partial else "+ curves"
    report = found.proposal["report"]
    learned = {
        curves: report["rmse_q_rad"],
        "formulas instead": report.get("formulas_rmse_q_rad"),
    }
    return steps + [(name, None, left) for name, left in learned.items() if left is not None]


def _label(step: dict[str, Any], titles: dict[str, str]) -> str:
    if step["titles"]:
        return f"+ {listed(step['titles'])}"
    return f"without {listed([titles.get(name, name) for name in step['dropped']])}"


def same_gains(compared: Compared) -> bool:
    """Whether every recording has one Kp and one Kd for all joints."""
    return all(
        len(set(log["kp"])) == 1 and len(set(log["kd"])) == 1 for log in compared.numbers["logs"]
    )


def mapped(compared: Compared) -> list[str | None]:
    """Joints with an error for more than one pair of gains, so that a map over gains says more.

    None stands for all of them together, where they had the same gains.
    """
    counts = Counter(cell["joint"] for cell in compared.numbers["cells"])
    together = (None,) if same_gains(compared) else ()
    return [joint for joint in (*together, *compared.traces.joints) if counts[joint] > 1]


def noise_density(compared: Compared) -> float | None:
    """Amplitude density mrad/√Hz of white noise with the noise floor's RMS."""
    floor, time = compared.numbers["noise_floor_rad"], compared.traces.columns["time"]
    at = compared.traces.at(0, int(compared.traces.joint[0]))
    if not floor or len(at) < 2:
        return None
    return 1e3 * floor * float(np.sqrt(2 * np.median(np.diff(time[at]))))
