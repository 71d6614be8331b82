"""How joints answer their commands: motion, frequency response, and where they lie in ω_n and ζ."""

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from t2l.figures.style import COLOURS, shown, styled
from t2l.response.joints import JointResponse

SHOWN_S = 6.0  # of the first motion
MOST = 12  # rows; the map holds all


def response_map(found: Sequence[JointResponse], stiff_from_hz: float) -> Figure:
    """ω_n over ζ of every joint with 95 % intervals, and the four regions."""
    with styled():
        figure, axes = plt.subplots(figsize=(5.5, 4.2))
        joints = list(dict.fromkeys(response.joint for response in found))
        for number, joint in enumerate(joints):
            members = [r.fit for r in found if r.joint == joint]
            told = [fit for fit in members if np.isfinite(fit.covariance).all()]
            if not told:
                continue
            x, y = (np.array([getattr(fit, key) for fit in told]) for key in ("omega", "zeta"))
            across, along = (
                np.abs(np.array([fit.interval(i) for fit in told]).T - centre)
                for i, centre in ((0, x), (1, y))
            )
            hz = 2 * np.pi
            axes.errorbar(
                x / hz, y, xerr=across / hz, yerr=along, fmt="o", ms=4, lw=0.8,
                color=COLOURS[number % len(COLOURS)], label=shown(joint),
            )  # fmt: skip
        axes.set(xscale="log", yscale="log", xlabel="natural frequency ω_n / 2π [Hz]")
        axes.set_ylabel("damping ratio ζ")
        low, high = np.array([r.fit.omega for r in found]).min(), max(r.fit.omega for r in found)
        axes.set_xlim(low / hz / 2, min(high / hz * 2, 500.0))
        bottom, top = (f(r.fit.zeta for r in found) for f in (min, max))
        axes.set_ylim(min(bottom / 2, 0.5), min(max(top * 2, 2.0), 100.0))
        axes.axhline(1.0, color="0.6", lw=0.8)
        axes.axvline(stiff_from_hz, color="0.6", lw=0.8)
        for text, x, y in (("CO", 0.02, 0.98), ("SO", 0.98, 0.98), ("CU", 0.02, 0.02),
                           ("SU", 0.98, 0.02)):  # fmt: skip
            axes.text(
                x, y, text, transform=axes.transAxes, color="0.4",
                ha="left" if x < 0.5 else "right", va="bottom" if y < 0.5 else "top",
            )  # fmt: skip
        axes.legend(fontsize=7)
    return figure


def response_motions(found: Sequence[JointResponse]) -> Figure:
    """Command, motion and fit of the first joints, and their frequency responses."""
    chosen = found[:MOST]
    with styled():
        figure, rows = plt.subplots(
            len(chosen), 2, figsize=(8.0, 1.9 * len(chosen)), squeeze=False, width_ratios=(2, 1)
        )
        for (left, right), response in zip(rows, chosen, strict=True):
            time, command, q = response.rows[0]
            held, measured = time <= SHOWN_S, np.isfinite(q)
            left.step(time[held], command[held], where="post", color="0.6", label="command")
            at = held & measured
            left.plot(time[at], q[at], ".", ms=3, color=COLOURS[0], label="motion")
            left.plot(
                time[measured][held[measured]], response.fit.predicted[0][held[measured]],
                color=COLOURS[1], lw=1.0, label="second order",
            )  # fmt: skip
            left.set_title(f"{shown(response.label)}, {shown(response.joint)}", fontsize=8)
            left.set_xlabel("time [s]")
            if response.frequencies is not None:
                f = response.frequencies
                right.errorbar(f.hz, f.gain, yerr=1.96 * f.gain_error, fmt=".", color=COLOURS[0])
                grid = 2j * np.pi * np.geomspace(f.hz[0], f.hz[-1], 100)
                omega, zeta = response.fit.omega, response.fit.zeta
                h = response.fit.gain / ((grid / omega) ** 2 + 2 * zeta * grid / omega + 1)
                right.plot(grid.imag / (2 * np.pi), np.abs(h), color=COLOURS[1], lw=1.0)
                right.set_ylim(0.0, 1.2 * max(1.0, f.gain.max(), np.abs(h).max()))
                right.set_xlabel("frequency [Hz]")
                right.set_ylabel("gain")
        rows[0, 0].legend(fontsize=7, loc="upper right")
    return figure
