"""What a diagnosis adds to its results beside its verdict: the one place that knows these keys."""

from typing import Any, TypedDict

from t2l.diagnose.results import Found


class Told(TypedDict):
    """What the page shows of it, where it is there.

    Attributes:
        chosen_share: by effect, in what part of resampled recordings it was chosen.
        curves: learned torques, each with `title`, `x` and `y` and `band` (low, high), `unit`.
    """

    chosen_share: dict[str, float]
    curves: list[dict[str, Any]]


def told(found: Found) -> Told:
    """`chosen_share` and learned curves of an explanation; empty where it has none."""
    content = found.explanation or {}
    shares: dict[str, float] = {}
    for entry in (content, *content.get("steps", [])):
        share = entry.get("chosen_share") if isinstance(entry, dict) else None
        if isinstance(share, dict):
            shares |= {str(k): float(v) for k, v in share.items() if _is_share(v)}
        elif _is_share(share) and isinstance(entry.get("effect"), str):
            shares[entry["effect"]] = float(share)
    curves = content.get("learned_curves", [])
    curves = [c for c in curves if isinstance(c, dict)] if isinstance(curves, list) else []
    return Told(chosen_share=shares, curves=curves)


def _is_share(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and 0 <= value <= 1
