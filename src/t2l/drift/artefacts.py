"""What a check found, for people and for programs."""

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from t2l.artefacts import write_text
from t2l.drift.verdict import DRIFTED, RULE, UNTOLD, EffectVerdict
from t2l.identify.levels import PROMISING
from t2l.identify.refit import Refit

CHECK = "check.json"
UNEXPLAINED = PROMISING  # times the noise: what a refit leaves beyond is not these effects


def summary(found: Sequence[EffectVerdict], new: Refit, noise_rad: float) -> dict[str, Any]:
    """Everything that was found; errors in rad."""
    return {
        "sentence": sentence(found, new, noise_rad),
        "rule": RULE,
        "noise_rad": noise_rad,
        "rmse_q_rad": {"adopted": new.before, "refitted": new.after},
        "effects": [asdict(one) for one in found],
    }


def sentence(found: Sequence[EffectVerdict], new: Refit, noise_rad: float) -> str:
    """The answer in words."""
    drifted = [one.effect for one in found if one.verdict == DRIFTED]
    untold = [one.effect for one in found if one.verdict == UNTOLD]
    parts = [f"Drifted: {', '.join(drifted)}." if drifted else "No adopted effect has drifted."]
    if untold:
        parts.append(f"The log does not tell: {', '.join(untold)}.")
    if new.after > UNEXPLAINED * noise_rad:
        parts.append(
            f"Refitted, the model leaves {1e3 * new.after:.3g} mrad where the noise is "
            f"{1e3 * noise_rad:.3g}: something else is missing; see t2l diagnose."
        )
    return " ".join(parts)


def table(found: Sequence[EffectVerdict]) -> str:
    """One line a parameter."""
    lines = []
    for one in found:
        lines.append(
            f"{one.effect}: {one.verdict} (error {100 * one.error_if_held:+.1f} % if held)"
        )
        for change in one.changes:
            place = f" of {change.joint}" if change.joint else ""
            low, high = change.interval
            lines.append(
                f"    {change.parameter}{place}: adopted {change.adopted:.4g}, now "
                f"{change.found:.4g} ({low:.4g} to {high:.4g}) {change.unit}"
                + ("" if change.determined else ", hardly determined")
            )
    return "\n".join(lines)


def write_check(content: dict[str, Any], path: Path | str) -> None:
    """Write check.json."""
    write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n", path)
