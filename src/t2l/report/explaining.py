"""Sections about effects: the error falling, each step's candidates, what remains."""

from collections.abc import Sequence
from html import escape
from typing import Any

from t2l.diagnose.results import Found, Step, titles_of
from t2l.report.pieces import HELD_OUT, NOISE_FLOOR, figure
from t2l.report.words import estimate, listed, mrad, number, readable, sentence


def falling(found: Found) -> str:
    """The error after every step."""
    return "<h2>The error falls</h2>\n" + figure(
        '<div class="plot" data-plot="falling"></div>',
        f"RMS position error after each added effect. Held out: {HELD_OUT}; an effect must lower "
        f"the error there to count. Noise floor: {NOISE_FLOOR}.",
    )


def step(found: Found, step: Step, number_of: int) -> list[str]:
    """What a step's diagnosis found; nothing for a last one that adopted nothing."""
    if step.adopted is None:
        if len(found.steps) > 1 or step.diagnosis["verdict"] == "no_missing_effect":
            return []
        return candidates(step, number_of, "What each known effect would explain")
    title = titles_of(found).get(step.adopted, readable(step.adopted))
    return candidates(step, number_of, f"Step {number_of + 1}: {title}")


def candidates(step: Step, number_of: int, title: str) -> list[str]:
    """The first candidate with its reasons and numbers, and all others beside it."""
    entries = step.diagnosis["ranking"]
    parts = [f"<h2>{escape(title)}</h2>"]
    chosen = step.adopted or (entries[0]["effect"] if entries else None)
    entry = next((e for e in entries if e["effect"] == chosen), None)
    if entry is not None:
        parts.append(_reason(step, entry, entries))
    if entries:
        parts.append(
            figure(
                f'<div class="plot" data-plot="ranking" data-step="{number_of}"></div>',
                "Every known effect fitted to the training recordings, one at a time, and judged "
                "on held-out ones: by how much the error falls there, with 95 % intervals. Below "
                "zero an effect makes it worse. Of effects that explain alike, the one with fewer "
                "parameters comes first; one that merely contains it is no rival.",
            )
        )
        parts.append(_all_candidates(entries))
    return parts


def _reason(step: Step, entry: dict[str, Any], entries: Sequence[dict[str, Any]]) -> str:
    titles = {e["effect"]: e["title"] for e in entries}
    before = step.diagnosis["baseline"]["heldout_rmse_q_rad"]
    parts = [f"<p>{sentence(entry['why'])}</p>"]
    if step.diagnosis["verdict"] == "missing_effect":
        parts.append(
            f"<p>The held-out error falls from {mrad(before)} to "
            f"{mrad(entry['heldout_rmse_q_rad'])}.</p>"
        )
        parts.append(_parameters(entry))
    if entry["tied_with"]:
        tied = listed([titles.get(name, readable(name)) for name in entry["tied_with"]])
        text = f"The recordings cannot tell it from {escape(tied)}, which explains as much."
        experiment = step.diagnosis.get("separating_experiment")
        if experiment:
            text += f" To tell them apart: {sentence(experiment['sentence'])}"
        parts.append(f'<div class="note"><p>{text}</p></div>')
    return "\n".join(parts)


def _parameters(entry: dict[str, Any]) -> str:
    rows = ""
    for name, p in entry["parameters"].items():
        value, interval = estimate(p["value"], p["ci95"])
        rows += (
            f'<tr><td>{escape(name)}</td><td class="n">{value}</td><td class="n">{interval}</td>'
            f'<td>{escape(p["unit"])}</td><td class="wide">{escape(p["meaning"])}</td></tr>'
        )
    notes = "".join(f"<li>{sentence(note)}</li>" for note in entry.get("notes", []))
    notes = f'<ul class="notes">{notes}</ul>' if notes else ""
    return (
        '<div class="scroll"><table><tr><th>parameter</th><th class="n">value</th>'
        '<th class="n">95 % interval</th><th>unit</th><th>meaning</th></tr>'
        f"{rows}</table></div>{notes}"
    )


def _all_candidates(entries: Sequence[dict[str, Any]]) -> str:
    rows = "".join(
        f'<tr><td>{escape(e["title"])}</td><td class="n">{mrad(e["heldout_rmse_q_rad"])}</td>'
        f'<td class="wide">{sentence(e["why"])}</td></tr>'
        for e in entries
    )
    return (
        "<details><summary>Why, for every candidate</summary>"
        '<div class="scroll"><table><tr><th>effect</th><th class="n">held-out error</th>'
        f"<th>why</th></tr>{rows}</table></div></details>"
    )


def remaining(step: Step) -> str:
    """What the last diagnosis left unexplained."""
    diagnosis = step.diagnosis
    error, floor = diagnosis["baseline"]["heldout_rmse_q_rad"], diagnosis["noise_floor_rad"]
    if diagnosis["verdict"] == "no_missing_effect":
        return (
            '<h2>What remains</h2>\n<div class="note good"><p>Nothing but noise: the held-out '
            f"error of {mrad(error)} is what measurement leaves ({mrad(floor)}).</p></div>"
        )
    remaining = [text for text in diagnosis.get("remaining", []) if text]
    if diagnosis["verdict"] == "unexplained":
        text = (
            f"An error of {mrad(error)} remains on held-out data, {number(error / floor, 2)} times "
            "the noise, and no known effect removes it."
        )
    else:
        text = f"Before this step the held-out error was {mrad(error)}, and most of it was here:"
    items = "".join(f"<li><span>{sentence(text)}</span></li>" for text in remaining)
    listing = f'<ul class="shares">{items}</ul>' if items else ""
    return f'<h2>What remains</h2>\n<div class="note"><p>{text}</p></div>{listing}'


def model(found: Found) -> str:
    """The final model's YAML."""
    if found.model_yaml is None:
        return ""
    return (
        "<h2>The final model</h2>\n<p>It lies beside this page as <code>model.yaml</code>; "
        "<code>t2l compare LOG… --model model.yaml --out DIR</code> tries it on other "
        f"recordings.</p>\n<pre>{escape(found.model_yaml)}</pre>"
    )
