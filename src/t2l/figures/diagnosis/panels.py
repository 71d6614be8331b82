"""What the figures of one model, or of two (as it came, and final), share."""

from collections.abc import Sequence
from contextlib import AbstractContextManager

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from t2l.diagnose.results import Compared
from t2l.diagnose.traces import Traces
from t2l.plotting.style import COLOURS

BLUE, ORANGE, SKY, BLACK = COLOURS[0], COLOURS[1], COLOURS[5], COLOURS[6]
GREY = "#8a939d"


def placed_by_hand() -> AbstractContextManager[None]:
    """Without the automatic layout, which takes seconds for many panels."""
    return plt.rc_context({"figure.constrained_layout.use": False})


def place(figure: Figure, left, right, bottom, top, wspace=None, hspace=None) -> None:
    """Leave these margins in inches, and these parts of a panel between panels."""
    width, height = figure.get_size_inches()
    figure.subplots_adjust(
        left / width, bottom / height, 1 - right / width, 1 - top / height, wspace, hspace
    )


def joints_by_error(traces: Traces) -> list[int]:
    """Joints, the one with the largest squared error first."""
    squares = np.bincount(traces.joint, traces.error**2, len(traces.joints))
    return np.argsort(-squares).tolist()


def colours(compared: Sequence[Compared]) -> tuple[str, ...]:
    """Of the lines of one model, or of both."""
    return (BLUE,) if len(compared) == 1 else (ORANGE, BLUE)
