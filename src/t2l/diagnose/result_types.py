"""What figures and pages take from comparison.json, diagnosis.json, explanation.json, by type."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NotRequired, TypedDict

from pydantic import FiniteFloat, TypeAdapter, ValidationError

from t2l.artefacts import read_json
from t2l.errors import ArtefactError
from t2l.typed import describe

Interval = tuple[FiniteFloat, FiniteFloat]


class _Rms(TypedDict):
    rmse_q_rad: FiniteFloat | None


class _Log(_Rms):
    name: str
    kp: list[FiniteFloat]
    kd: list[FiniteFloat]
    duration_s: FiniteFloat
    command_rate_hz: FiniteFloat
    control_rate_hz: FiniteFloat
    gravity_compensation: bool


class _Joint(_Rms):
    share: FiniteFloat


class _Cell(TypedDict):
    joint: str | None
    kp: FiniteFloat
    kd: FiniteFloat
    rmse_q_rad: FiniteFloat


class _Finding(TypedDict):
    share: FiniteFloat
    sentence: str


class _Followed(TypedDict):
    condition: str
    fraction: FiniteFloat
    sentence: str


class _Contradiction(TypedDict):
    message: str


class Comparison(TypedDict):
    """Of comparison.json."""

    rmse_q_rad: FiniteFloat
    rmse_dq_rad_s: FiniteFloat | None
    noise_floor_rad: FiniteFloat | None
    robot: str
    effects: Mapping[str, Any]
    samples: int
    logs: list[_Log]
    joints: Mapping[str, _Joint]
    cells: list[_Cell]
    findings: list[_Finding]
    follows: list[_Followed]
    contradictions: list[_Contradiction]
    chatter: NotRequired[str | None]
    measured_torque: NotRequired[list[dict[str, Any]]]


class _Parameter(TypedDict):
    value: FiniteFloat
    ci95: Interval | None
    unit: str
    meaning: str


class _Improvement(TypedDict):
    fraction: FiniteFloat
    ci95: Interval


class _Candidate(TypedDict):
    effect: str
    title: str
    validation_rmse_q_rad: FiniteFloat
    test_rmse_q_rad: FiniteFloat | None
    improvement: _Improvement
    chosen_share: FiniteFloat | None
    parameters: Mapping[str, _Parameter]
    tied_with: list[str]
    simulated: bool
    why: str
    notes: NotRequired[list[str]]


class _Errors(TypedDict):
    train_rmse_q_rad: FiniteFloat
    validation_rmse_q_rad: FiniteFloat
    test_rmse_q_rad: FiniteFloat


class _Rival(TypedDict):
    effects: list[str]
    collinearity: NotRequired[FiniteFloat]
    validation_rmse_q_rad: NotRequired[FiniteFloat]


class _Confounded(TypedDict):
    effect: str
    not_told_from: list[_Rival]


class _Experiment(TypedDict):
    sentence: str


class Diagnosis(TypedDict):
    """Of diagnosis.json."""

    verdict: str
    noise_floor_rad: FiniteFloat
    baseline: _Errors
    ranking: list[_Candidate]
    sentence: NotRequired[str]
    training_recordings: NotRequired[list[str]]
    test_recordings: NotRequired[list[str]]
    remaining: NotRequired[list[str]]
    separating_experiment: NotRequired[_Experiment | None]
    confounded: NotRequired[list[_Confounded]]


class Tried(TypedDict):
    """A set of effects and curves that was compared with others."""

    titles: list[str]
    numbers: int
    left_out_rmse_q_rad: FiniteFloat
    simulated: bool


class _Step(_Errors):
    effects: list[str]
    titles: list[str]
    chosen_shares: list[FiniteFloat | None]
    dropped: list[str]
    tried: list[Tried]


class _Fitted(_Parameter):
    effect: str
    title: str
    joint: str | None
    parameter: str


class Explanation(TypedDict):
    """Of explanation.json."""

    steps: list[_Step]
    then_tried: list[Tried]
    final: bool
    verdict: str
    sentence: str
    noise_floor_rad: FiniteFloat
    parameters: NotRequired[list[_Fitted]]
    confounded: NotRequired[list[_Confounded]]


class _Formula(TypedDict):
    effect: str
    sentence: str
    report_rmse_q_rad: FiniteFloat | None


class _Curve(TypedDict):
    name: str
    law: str
    kind: str
    joint: str
    follows: str
    of: str
    variable: str
    unit: str
    at: list[FiniteFloat]
    torque: list[FiniteFloat]
    low: list[FiniteFloat]
    high: list[FiniteFloat]
    formula: _Formula | None
    note: str


class _Choice(TypedDict):
    baseline_rmse_q_rad: FiniteFloat
    rmse_q_rad: FiniteFloat


class _Report(TypedDict):
    baseline_rmse_q_rad: FiniteFloat | None
    rmse_q_rad: FiniteFloat | None
    formulas_rmse_q_rad: NotRequired[FiniteFloat | None]
    recordings: list[str]


class _Ceiling(TypedDict):
    law: str
    rmse_q_rad: FiniteFloat


class Proposal(TypedDict):
    """Of proposal.json."""

    verdict: str
    sentence: str
    noise_floor_rad: FiniteFloat
    choice: _Choice
    report: _Report
    fitted_recordings: list[str]
    curves: list[_Curve]
    ceilings: list[_Ceiling]


def read_content(path: Path, kind: type, what: str) -> dict[str, Any]:
    """The content of a JSON file, whose keys have the types of `kind`; others may be there.

    Raises:
        ArtefactError: they have not, or it is no such file.
    """
    content = read_json(path, what)
    try:
        TypeAdapter(kind).validate_python(content)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        key = ".".join(map(str, first["loc"]))
        found = "nothing" if first["type"] == "missing" else describe(first["input"])
        raise ArtefactError(path, f"{key}: {found}", f"{what} ({first['msg']})") from None
    return content
