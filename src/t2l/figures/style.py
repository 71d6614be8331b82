"""How every figure looks, and how it is written."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
from matplotlib.figure import Figure

from t2l.artefacts import whole

# Okabe and Ito (2008): told apart by readers with any colour vision
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")

_SETTINGS = {
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.labelsize": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.prop_cycle": matplotlib.cycler(color=COLOURS),
    "figure.constrained_layout.use": True,
    "savefig.dpi": 200,
    "legend.frameon": False,
    "pdf.fonttype": 42,
}


@contextmanager
def styled() -> Iterator[None]:
    """Draw in t2l's style."""
    with plt.rc_context(_SETTINGS):
        yield


def write(figure: Figure, paths: Sequence[Path | str]) -> None:
    """Write a figure to every path, each whole, in the format its suffix names."""
    for path in paths:
        # without dates, the same figure is the same file
        metadata = {"CreationDate": None} if str(path).endswith(".pdf") else None
        with whole(path) as draft:
            figure.savefig(draft, metadata=metadata)
    plt.close(figure)


def title(name: str) -> str:
    """A task's name as a heading."""
    return name.replace("_", " ").title()


def plain(value: float) -> str:
    """A gain as a tick label."""
    return f"{value:g}"
