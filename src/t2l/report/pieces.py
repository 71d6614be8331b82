"""Pieces of HTML that several sections use."""

from collections.abc import Iterable, Sequence
from html import escape
from typing import Any

from t2l.diagnose.results import Step
from t2l.report.words import listed, sentence

HELD_OUT = "recordings, or parts of them, that no parameter was fitted to"
NOISE_FLOOR = "the error a perfect model would still show, from encoder noise and quantisation"


def head(kicker: str, title: str, lead: str) -> str:
    """Title and lead; `lead` is HTML."""
    return f'<p class="kicker">{kicker}</p>\n<h1>{escape(title)}</h1>\n<p class="lead">{lead}</p>'


def tiles(numbers: Iterable[tuple[str, str]]) -> str:
    """Numbers with what they mean, both HTML, side by side."""
    inside = "".join(f"<div><b>{value}</b><span>{text}</span></div>" for value, text in numbers)
    return f'<div class="numbers">{inside}</div>'


def choice(
    plot: str, key: str, label: str, options: Sequence[tuple[Any, str]], chosen: Any = None
) -> str:
    """A menu for the plots named `plot`: values and their texts."""
    inside = "".join(
        f'<option value="{value}"{" selected" if value == chosen else ""}>{escape(text)}</option>'
        for value, text in options
    )
    return f'<label>{label} <select data-for="{plot}" data-key="{key}">{inside}</select></label>'


def figure(plots: str, caption: str, choices: str = "") -> str:
    """Plots with menus above and a caption below, all HTML."""
    if choices:
        choices = f'<div class="choices">{choices}</div>'
    return f"<figure>{choices}{plots}<figcaption>{caption}</figcaption></figure>"


def shares(entries: Iterable[tuple[float, str]]) -> str:
    """Sentences on bars as long as their shares."""
    items = "".join(
        f'<li><i style="width:{100 * min(max(share, 0.0), 1.0):.0f}%"></i>'
        f"<span>{sentence(text)}</span></li>"
        for share, text in entries
    )
    return f'<ul class="shares">{items}</ul>'


def held_out(step: Step) -> str:
    """What a diagnosis was judged on, as HTML."""
    held, trained = (
        step.diagnosis.get(key, []) for key in ("heldout_recordings", "training_recordings")
    )
    if not held:
        return HELD_OUT
    if set(held) == set(trained):
        return f"every other block of time: {HELD_OUT}"
    few = f": {escape(listed(held))}" if len(held) <= 6 else ""
    return f"{len(held)} of them ({HELD_OUT}){few}"
