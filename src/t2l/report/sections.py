"""The story, top to bottom: which sections a page has, and its headline."""

from html import escape
from typing import Any

from t2l.diagnose.results import Found, Step, titles_of
from t2l.report import comparing, explaining, pieces
from t2l.report.words import listed, mrad, number, readable, sentence

VERDICTS = {
    "missing_effect": "an effect is missing",
    "no_missing_effect": "nothing is missing: only measurement noise is left",
    "unexplained": "an error remains that no known effect explains",
}


def tell(found: Found) -> tuple[str, list[str]]:
    """Title of the page, and its sections as HTML."""
    if found.explanation is not None:
        return _explained(found)
    if found.steps:
        return _diagnosed(found)
    return _compared(found)


def _compared(found: Found) -> tuple[str, list[str]]:
    compared = found.compared[0]
    numbers = compared.numbers
    title = f"{comparing.robot(numbers)}: model and recordings compared"
    return title, [
        pieces.head("t2l compare", title, _where_it_fails(numbers)),
        pieces.tiles(_comparison_tiles(numbers)),
        comparing.what(found),
        comparing.contradictions(numbers),
        comparing.where(found),
        comparing.overlays(found),
        comparing.follows(found),
        comparing.spectrum(found),
        comparing.recordings(found),
    ]


def _diagnosed(found: Found) -> tuple[str, list[str]]:
    step = found.steps[0]
    title = "Which effect the model lacks"
    tiles = [
        (mrad(step.diagnosis["baseline"]["heldout_rmse_q_rad"]), "held-out error of the model"),
        (mrad(step.diagnosis["noise_floor_rad"]), f"noise floor: {pieces.NOISE_FLOOR}"),
        (str(len(step.diagnosis["ranking"])), "known effects tried"),
    ]
    return title, [
        pieces.head(
            "t2l diagnose", title, sentence(step.diagnosis.get("sentence") or _verdict(step))
        ),
        pieces.tiles(tiles),
        _split(step),
        *explaining.candidates(step, 0, "What each known effect would explain"),
        explaining.remaining(step),
    ]


def _explained(found: Found) -> tuple[str, list[str]]:
    robot = comparing.robot(found.compared[0].numbers) if found.compared else "the robot"
    title = f"What the model of {robot} lacked"
    return title, [
        pieces.head("t2l explain", title, _what_was_added(found)),
        pieces.tiles(_explanation_tiles(found)),
        comparing.what(found) if found.compared else "",
        comparing.contradictions(found.compared[0].numbers) if found.compared else "",
        explaining.falling(found),
        *(
            part
            for number, step in enumerate(found.steps)
            for part in explaining.step(found, step, number)
        ),
        *(
            [
                comparing.overlays(found),
                comparing.where(found),
                comparing.follows(found),
                comparing.spectrum(found),
            ]
            if found.compared
            else []
        ),
        explaining.remaining(found.steps[-1]) if found.steps else "",
        explaining.model(found),
        comparing.recordings(found) if found.compared else "",
    ]


def _where_it_fails(numbers: dict[str, Any]) -> str:
    error = f"The model is off by {mrad(numbers['rmse_q_rad'])} RMS"
    floor = numbers["noise_floor_rad"]
    if floor:
        ratio = numbers["rmse_q_rad"] / floor
        error += f", {number(ratio, 2)} times the measurement noise"
    found = numbers["findings"]
    return f"{error}. {sentence(found[0]['sentence'])}" if found else f"{error}."


def _comparison_tiles(numbers: dict[str, Any]) -> list[tuple[str, str]]:
    tiles = [(mrad(numbers["rmse_q_rad"]), "RMS error of the position, measured minus simulated")]
    if numbers["rmse_dq_rad_s"] is not None:
        tiles.append((f"{number(numbers['rmse_dq_rad_s'])} rad/s", "RMS error of the velocity"))
    if numbers["noise_floor_rad"] is not None:
        tiles.append((mrad(numbers["noise_floor_rad"]), f"noise floor: {pieces.NOISE_FLOOR}"))
    tiles.append((str(len(numbers["logs"])), f"recordings, {numbers['samples']:,} samples"))
    return tiles


def _what_was_added(found: Found) -> str:
    steps, floor = found.explanation["steps"], found.explanation["noise_floor_rad"]
    titles = titles_of(found)
    added = [escape(titles.get(s["effect"], readable(s["effect"]))) for s in steps[1:]]
    first, last = steps[0]["heldout_rmse_q_rad"], steps[-1]["heldout_rmse_q_rad"]
    if not added:
        return sentence(found.explanation["sentence"])
    text = (
        f"With {listed(added)} added, the held-out error falls from {mrad(first)} to "
        f"{mrad(last)}; measurement noise alone makes {mrad(floor)}."
    )
    verdict = found.explanation["verdict"]
    if verdict == "no_missing_effect":
        return f"{text} Nothing more is missing."
    if verdict == "unexplained":
        return f"{text} No known effect explains the rest."
    return f"{text} More would help, but the search ended at its limit of effects."


def _explanation_tiles(found: Found) -> list[tuple[str, str]]:
    steps = found.explanation["steps"]
    return [
        (mrad(steps[0]["heldout_rmse_q_rad"]), "held-out error of the model as it came"),
        (mrad(steps[-1]["heldout_rmse_q_rad"]), f"held out, final model ({pieces.HELD_OUT})"),
        (mrad(found.explanation["noise_floor_rad"]), f"noise floor: {pieces.NOISE_FLOOR}"),
        (str(len(steps) - 1), "effects added"),
    ]


def _split(step: Step) -> str:
    return f'<dl class="facts"><dt>held out</dt><dd>{pieces.held_out(step)}</dd></dl>'


def _verdict(step: Step) -> str:
    return VERDICTS.get(step.diagnosis["verdict"], step.diagnosis["verdict"])
