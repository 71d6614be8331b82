"""Learned curves beside the torque that is hidden, as a picture.

The hidden torque is asked of the generator's own effect, at every value of the curve's variable.
Where it does not follow one variable, only the curve is shown.
"""

from collections.abc import Sequence
from pathlib import Path
from textwrap import fill

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import SubFigure
from matplotlib.ticker import MaxNLocator

from benchmarks.hidden_effects.cases import ROBOTS, Case
from benchmarks.hidden_effects.effects import HiddenEffect, Plant, State
from benchmarks.hidden_effects.real_effects import Warming
from t2l.effects.law import FRICTION, TORQUE
from t2l.plotting.style import COLOURS, styled, write
from t2l.propose.expression import Formula

COLUMNS = 4
WIDTH = 8.6  # inches: a page shows it at about 100 points an inch, and letters as large as its own
FAR = 1.0  # rad, of a motion after which dry friction slides
SLOW = 1e-6  # rad/s, at which only friction resists
LASTS_S = 60.0  # longer than any session


def draw(results: Sequence[tuple[Case, dict]], path: Path) -> None:
    """Curves of cases and what was proposed, as `benchmarks.proposals` keeps it.

    A panel for each curve. Constants share one panel: their distance from what is hidden, which a
    panel of its own would stretch until it looked large.
    """
    shown = [(case, curve) for case, result in results for curve in result["curves"]]
    if not shown:
        return
    constants = [pair for pair in shown if _constant(*pair) is not None]
    curves = [pair for pair in shown if _constant(*pair) is None]
    rows = -(-len(curves) // COLUMNS)
    # apart, so that long names of constants do not push curves aside
    heights = {"curves": 1.8 * rows + 0.3, "constants": 0.9 + 0.24 * len(constants)}
    kept = {"curves": curves, "constants": constants}
    heights = [heights[name] for name, pairs in kept.items() if pairs]
    with styled():
        figure = plt.figure(figsize=(WIDTH, sum(heights)))
        parts = list(figure.subfigures(len(heights), 1, height_ratios=heights, squeeze=False).flat)
        if constants:
            _constants(parts[-1].subplots(), constants)
        if curves:
            _curves(parts[0], parts[0].subplots(rows, COLUMNS, squeeze=False), curves)
        write(figure, [path])


def _curves(figure: SubFigure, axes: np.ndarray, curves: Sequence[tuple[Case, dict]]) -> None:
    for panel, (case, curve) in zip(axes.flat, curves, strict=False):
        _panel(panel, case, curve)
    for panel in axes.flat[len(curves) :]:
        panel.axis("off")
    drawn = [panel.get_legend_handles_labels() for panel in axes.flat]
    legend = {label: handle for pair in drawn for handle, label in zip(*pair, strict=True)}
    place = {"loc": "outside upper center", "ncols": len(legend)}
    figure.legend(legend.values(), legend.keys(), **place)
    figure.supylabel("torque [N·m]", fontsize=9)


def _constant(case: Case, curve: dict) -> float | None:
    """What is hidden, N·m, where a curve is one number beside another that is not zero."""
    if curve["follows"] != "constant":
        return None
    truth = hidden_torque(case, curve, np.zeros(1))
    return None if truth is None or truth[0] == 0 else float(truth[0])


def _constants(panel: plt.Axes, constants: Sequence[tuple[Case, dict]]) -> None:
    """Learned over hidden, less one, in per cent, with the band; a row a curve."""
    for row, (case, curve) in enumerate(constants):
        truth = _constant(case, curve)
        value, *ends = (100 * (curve[key][0] / truth - 1) for key in ("torque", "low", "high"))
        panel.plot(ends, [row, row], color=COLOURS[0], alpha=0.3, lw=6, solid_capstyle="butt")
        panel.plot(value, row, "o", color=COLOURS[0], ms=4)
    panel.axvline(0, color="black", ls=":", lw=1.5)
    panel.set_yticks(range(len(constants)), [_title(*pair) for pair in constants], fontsize=8)
    panel.set_ylim(len(constants) - 0.4, -0.6)
    panel.xaxis.set_major_locator(MaxNLocator(7))
    panel.tick_params(axis="x", labelsize=8)
    panel.set_xlabel("constants: learned over hidden, less 1 [%], with 95 % band", fontsize=8)


def _panel(panel: plt.Axes, case: Case, curve: dict) -> None:
    x, y, low, high = (np.array(curve[key]) for key in ("at", "torque", "low", "high"))
    panel.fill_between(x, low, high, color=COLOURS[0], alpha=0.3, lw=0, label="95 % band")
    panel.plot(x, y, color=COLOURS[0], label="learned curve")
    if curve["formula"]:
        formula = Formula(*(curve["formula"][key] for key in ("text", "values", "units")))
        panel.plot(x, formula(x) + 0 * x, "--", color=COLOURS[1], lw=1.2, label="its formula")
    truth = hidden_torque(case, curve, x)
    if truth is not None:
        panel.plot(x, truth, ":", color="black", lw=1.5, label="hidden")
    panel.set_title(fill(_title(case, curve), 22), size=8)
    if curve["follows"] == "constant":
        panel.set_xticks([])
        panel.set_ylim(*sorted((0.0, 1.2 * y[0])))
    panel.set_xlabel(curve["follows"] + (f" [{curve['unit']}]" if curve["unit"] else ""), size=8)
    panel.xaxis.set_major_locator(MaxNLocator(4))
    panel.yaxis.set_major_locator(MaxNLocator(4))
    panel.tick_params(labelsize=8)


def _title(case: Case, curve: dict) -> str:
    return f"{_plain(case.name)}: {curve['kind']}, {curve['joint']}"


def _plain(name: str) -> str:
    first, *rest = name.split("_")
    return " ".join(rest if first.startswith("test") else [first, *rest])


def hidden_torque(case: Case, curve: dict, x: np.ndarray) -> np.ndarray | None:
    """What is hidden at values x (n,) of a curve's variable, N·m; None if it is no such torque."""
    joints = ROBOTS[case.robot].joints
    joint, (effect, *more) = joints.index(curve["joint"]), case.hidden
    if more or curve["kind"] not in (TORQUE, FRICTION) or curve["follows"] not in _STATES:
        return None
    if curve["of"] != curve["joint"]:
        return None
    plant = Plant(joints, 1e-3, np.ones(len(joints)), np.ones(len(joints)))
    try:
        ways = [[_torque(effect, plant, joint, curve, at, way) for at in x] for way in (1, -1)]
    except NotImplementedError:
        return None
    forward, backward = np.array(ways)
    if curve["kind"] == FRICTION:
        return (backward - forward) / 2
    # dry friction cancels
    return forward if curve["follows"] == "velocity" else (forward + backward) / 2


def _torque(
    effect: HiddenEffect, plant: Plant, joint: int, curve: dict, x: float, way: int
) -> float:
    """On a joint that has slid that way, or as it moves."""
    n = len(plant.joints)
    given = {"q": 0.0, "v": way * SLOW, "t": 0.0} | _STATES[curve["follows"]](x, way, effect)
    effect.start(plant)
    begin = given["q"] - np.sign(given["v"]) * FAR
    # of what acts since the start, that is at 0
    for at, t in ((begin, 0.0), (given["q"], given["t"])):
        q, v = np.zeros(n), np.zeros(n)
        q[joint], v[joint] = at, given["v"]
        torque = effect.torque(State(t, q, v, q, v, np.zeros(n)))
    return float(torque[joint])


def _when(temperature: float, effect: HiddenEffect) -> float:
    """s: when it is as warm."""
    if not isinstance(effect, Warming):
        raise NotImplementedError
    t = np.linspace(0.0, LASTS_S, 10_000)
    return float(np.interp(temperature, effect.temperature(t), t))


_STATES = {
    "constant": lambda x, way, effect: {},
    "position": lambda x, way, effect: {"q": x},
    "velocity": lambda x, way, effect: {"v": x},
    "speed": lambda x, way, effect: {"v": way * x},
    "time": lambda x, way, effect: {"t": x},
    "session time": lambda x, way, effect: {"t": x},
    "phase": lambda x, way, effect: {"t": x},
    "temperature": lambda x, way, effect: {"t": _when(x, effect)},
}
