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
    TRACES,
)
from t2l.diagnose.result_types import read_content
from t2l.diagnose.traces import Traces, read_traces
from t2l.effects.registry import builtin
from t2l.errors import ArtefactError
from t2l.names import listed

LEARNED = "learned_"  # format: how the name of a learned curve begins


@dataclass(frozen=True)
class Compared:
    """A model's comparison: its numbers, its samples, and what to call the model."""

    label: str
    numbers: dict[str, Any]
    traces: Traces


@dataclass(frozen=True)
class Found:
    """Everything that a figure or a page may tell.

    Attributes:
        compared: one model, or the one that came and the final one; may be empty.
        diagnosis: content of diagnosis.json.
        explanation: content of explanation.json.
        model_yaml: the final model as text.
        proposal: content of proposal.json.
    """

    compared: list[Compared] = field(default_factory=list)
    diagnosis: dict[str, Any] | None = None
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
    def curves(self) -> list[str]:
        """Names of learned curves among what was added."""
        return [one["effect"] for one in self.added if one["effect"].startswith(LEARNED)]

    @property
    def formulas_rmse_q_rad(self) -> float | None:
        """Test error with formulas in place of the learned curves, where there are any."""
        return self.proposal["report"].get("formulas_rmse_q_rad") if self.proposal else None

    @property
    def untold(self) -> dict[str, list[dict[str, Any]]]:
        """By name of an adopted effect: what the recordings cannot tell it from."""
        confounded = (self.explanation or {}).get("confounded", [])
        return {entry["effect"]: entry["not_told_from"] for entry in confounded}


def read_found(folder: Path | str) -> Found:
    """Read a folder.

    Raises:
        ArtefactError: it holds nothing to tell, or a file is malformed.
    """
    folder = Path(folder)
    if os.path.lexists(folder / EXPLANATION):
        return _explained(folder)
    if os.path.lexists(folder / DIAGNOSIS):
        return Found(diagnosis=_diagnosis(folder))
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
    compared = [
        _compared(folder / name, label)
        for name, label in ((BEFORE, "model as it came"), (AFTER, "final model"))
        if os.path.lexists(folder / name / COMPARISON)
    ]
    if len(compared) == 2 and not _alike(*compared):
        found = "other recordings than those of the model as it came"
        raise ArtefactError(folder / AFTER / TRACES, found, "the same")
    model = folder / MODEL
    text = read_text(model, "a model") if os.path.lexists(model) else None
    return Found(compared, None, explanation, text, _proposal(folder / PROPOSED))


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
    """Titles of effects by name: of this package's, and of those that were found."""
    steps = found.explanation["steps"] if found.explanation else []
    ranking = found.diagnosis["ranking"] if found.diagnosis else []
    return (
        {n: t for step in steps for n, t in zip(step["effects"], step["titles"], strict=True)}
        | {name: effect.title for name, effect in builtin().items()}
        | {entry["effect"]: entry["title"] for entry in ranking}
    )


def kind_of(entry: dict[str, Any], diagnosis: dict[str, Any]) -> str:
    """Of an entry of a ranking: "best", "tied" with it, "linear" if not simulated, or "other"."""
    if not entry["simulated"]:
        return "linear"
    if diagnosis["verdict"] != "missing_effect":
        return "other"
    first = diagnosis["ranking"][0]
    if entry is first:
        return "best"
    return "tied" if entry["effect"] in first["tied_with"] else "other"


def errors_by_step(found: Found) -> list[tuple[str, float | None, float]]:
    """Label, training and test error in rad of the steps of an explanation.

    The model as it came, what every step added, and formulas in place of the learned curves, of
    which there is no training error.
    """
    first, *rest = found.explanation["steps"]
    labels = ["model as it came", *(label_of(step, titles_of(found)) for step in rest)]
    errors = [(s["train_rmse_q_rad"], s["test_rmse_q_rad"]) for s in (first, *rest)]
    steps = [(label, *both) for label, both in zip(labels, errors, strict=True)]
    left = found.formulas_rmse_q_rad
    return steps if left is None else [*steps, ("formulas for curves", None, left)]


def label_of(step: dict[str, Any], titles: dict[str, str]) -> str:
    """What a step of an explanation did: added effects, or dropped some."""
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
