"""What an explanation may add to its steps: the one place that knows these keys.

- `chosen_share` of a step, or by effect: in what part of resampled recordings it was chosen
- `learned_curves`: a list of torques that were learned, each with `title`, `variable` (what it is
  over, with its unit), `at` and `torque` (n numbers each) and perhaps `low` and `high`, its band
"""

from collections.abc import Mapping
from math import isfinite
from typing import Any, TypedDict

from t2l.diagnose.results import Found

NUMBERS = ("at", "torque", "low", "high")


class Told(TypedDict):
    """What of it the page shows; empty where it is not there, or not as it should be."""

    chosen_share: dict[str, float]
    curves: list[dict[str, Any]]


def told(found: Found) -> Told:
    """What an explanation says beyond its steps."""
    content = found.explanation or {}
    return Told(chosen_share=_shares(content), curves=_curves(content.get("learned_curves")))


def _shares(content: Mapping[str, Any]) -> dict[str, float]:
    shares: dict[str, float] = {}
    for entry in (content, *content.get("steps", [])):
        share, effect = entry.get("chosen_share"), entry.get("effect")
        if isinstance(share, Mapping):
            shares |= {str(name): float(v) for name, v in share.items() if _is_number(v)}
        elif _is_number(share) and isinstance(effect, str):
            shares[effect] = float(share)
    return shares


def _curves(content: Any) -> list[dict[str, Any]]:
    curves = []
    for entry in content if isinstance(content, list) else ():
        if not isinstance(entry, Mapping):
            continue
        numbers = {k: entry[k] for k in NUMBERS if _are_numbers(entry.get(k))}
        if {"at", "torque"} <= set(numbers) and len({len(v) for v in numbers.values()}) == 1:
            texts = {k: str(entry.get(k, "")) for k in ("title", "variable")}
            curves.append({**texts, **numbers})
    return curves


def _are_numbers(values: Any) -> bool:
    return isinstance(values, list) and bool(values) and all(map(_is_number, values))


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and isfinite(value)
