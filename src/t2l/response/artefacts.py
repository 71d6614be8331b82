"""What is found of responses as a table for people and a file for programs."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from t2l.artefacts import write_text
from t2l.response.joints import JointResponse
from t2l.response.region import REGIONS

GAINS = "gains.json"
FIGURES = "figures"
HEADER = (
    "motions", "joint", "ω_n [rad/s]", "ζ", "class", "lag [ms]", "overshoot", "explained",
)  # fmt: skip


def write_responses(
    found: Sequence[JointResponse], stiff_from_hz: float, path: Path | str
) -> dict[str, Any]:
    """Write and return what was found; a number that the motion does not tell is null."""
    content = {
        "stiff_from_hz": stiff_from_hz,
        "rule": "stiff where ω_n is at least stiff_from_hz, overdamped where ζ is at least 1",
        "classes": {
            name: sum(r.region.name == name and r.region.certain for r in found) for name in REGIONS
        },
        "uncertain": sum(not r.region.certain for r in found),
        "joints": [describe(response) for response in found],
    }
    write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n", path)
    return content


def describe(response: JointResponse) -> dict[str, Any]:
    """One joint's response, intervals at 95 %."""
    fit, frequencies = response.fit, response.frequencies
    measured = None
    if frequencies is not None:
        names = ("hz", "gain", "gain_error", "phase_rad", "phase_error_rad", "coherence")
        measured = {name: getattr(frequencies, name).tolist() for name in names}
    kp, kd = response.logged or (None, None)
    lag, overshoot = response.lag, response.overshoot
    return {
        "motions": response.label,
        "joint": response.joint,
        "kp_logged": kp,
        "kd_logged": kd,
        "commanded_amplitude": response.amplitude[0],
        "achieved_amplitude": response.amplitude[1],
        "lag_s": lag and lag.seconds,
        "lag_s_ci95": lag and lag.interval,
        "overshoot": overshoot and overshoot.fraction,
        "overshoot_ci95": overshoot and overshoot.interval,
        "steps": overshoot.steps if overshoot else 0,
        "omega_n_rad_s": fit.omega,
        "omega_n_rad_s_ci95": _finite(fit.interval(0)),
        "zeta": fit.zeta,
        "zeta_ci95": _finite(fit.interval(1)),
        "delay_s": fit.delay_s,
        "delay_s_ci95": fit.delay_interval,
        "gain": fit.gain,
        "gain_ci95": fit.gain_interval,
        "rmse": fit.rmse,
        "explained": fit.explained if fit.moves else None,
        "class": response.region.name,
        "class_certain": response.region.certain,
        "class_probability": response.region.probability,
        "frequency_response": measured,
    }


def table(found: Sequence[JointResponse]) -> str:
    """One line a joint, for a terminal; a class that is not certain has a question mark."""
    lines = [HEADER, *(_line(response) for response in found)]
    widths = [max(len(line[i]) for line in lines) for i in range(len(HEADER))]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip()
        for line in lines
    )


def _line(response: JointResponse) -> tuple[str, ...]:
    fit, lag, over = response.fit, response.lag, response.overshoot
    return (
        response.label,
        response.joint,
        _with_interval(fit.omega, fit.interval(0)),
        _with_interval(fit.zeta, fit.interval(1)),
        response.region.name + ("" if response.region.certain else "?") if fit.moves else "-",
        "-" if lag is None else _with_interval(
            1e3 * lag.seconds, lag.interval and tuple(1e3 * end for end in lag.interval)
        ),
        "no steps" if over is None else f"{100 * over.fraction:.0f} % ({over.steps})",
        f"{100 * fit.explained:.1f} %" if fit.moves else "does not move",
    )  # fmt: skip


def _with_interval(value: float, interval: tuple[float, float] | None) -> str:
    if interval is None:
        return f"{value:.3g}"
    if _finite(interval) is None:
        return "not told"
    return f"{value:.3g} ({interval[0]:.3g} to {interval[1]:.3g})"


def _finite(interval: tuple[float, float]) -> tuple[float, float] | None:
    return interval if np.isfinite(interval).all() and interval[1] < 1e6 else None
