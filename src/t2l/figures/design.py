"""An experiment: its motions, and how well each parameter will be known."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from t2l.design.experiment import Experiment
from t2l.hardware.plan import Setup
from t2l.plotting.style import COLOURS, short, shown, styled

SHOWN_MOTIONS = 12
SHOWN_PARAMETERS = 60
COLUMNS = 4
# an error that is larger, or without bound, is drawn there
LARGEST = 1e3


def experiment_motions(experiment: Experiment, setup: Setup) -> Figure:
    """The commands of the first chosen motions, as offsets from the start."""
    chosen = experiment.chosen[:SHOWN_MOTIONS]
    rows = -(-len(chosen) // COLUMNS)
    names = short(setup.robot.joints)
    with styled():
        figure, axes = plt.subplots(
            rows, COLUMNS, figsize=(10, 0.6 + 1.7 * rows), squeeze=False, sharex=True
        )
        for panel in axes.flat[len(chosen) :]:
            panel.set_visible(False)
        for candidate, panel in zip(chosen, axes.flat, strict=False):
            motion = candidate.motion(setup)
            for j in np.flatnonzero(candidate.amplitude_rad):
                offset = motion.q_des[:, j] - setup.start[j]
                colour = COLOURS[j % len(COLOURS)]
                panel.plot(motion.time, offset, color=colour, label=names[setup.robot.joints[j]])
            panel.set_title(shown(candidate.name), fontsize=8)
        for panel in axes[:, 0]:
            panel.set_ylabel("offset [rad]")
        for panel in axes[-1]:
            panel.set_xlabel("time [s]")
        handles = {line.get_label(): line for panel in axes.flat for line in panel.lines}
        if len(setup.robot.joints) > 1:
            figure.legend(handles.values(), handles, loc="outside right upper")
    return figure


def expected_errors(experiment: Experiment) -> Figure:
    """Expected standard errors over plausible sizes: of one effect alone, and of all together."""
    entries = sorted(experiment.told.expected, key=lambda e: e.error / e.plausible_change)
    entries = entries[-SHOWN_PARAMETERS:]
    with styled():
        figure, axes = plt.subplots(figsize=(7, 1.2 + 0.17 * len(entries)))
        for key, colour, label in (
            ("error_together", COLOURS[1], "all effects unknown"),
            ("error", COLOURS[0], "its effect alone"),
        ):
            values = [getattr(e, key) / e.plausible_change for e in entries]
            axes.plot(
                np.minimum(values, LARGEST),
                range(len(entries)),
                "o",
                ms=4,
                color=colour,
                label=label,
            )
        axes.axvline(1.0, color=COLOURS[6], lw=0.8, ls="--")
        axes.set(
            xscale="log", ylim=(-1, len(entries)),
            xlabel=f"expected standard error / plausible size ({LARGEST:g}: that or more)",
        )  # fmt: skip
        axes.set_yticks(range(len(entries)), [shown(e.words) for e in entries], fontsize=7)
        axes.legend(loc="lower right")
    return figure
