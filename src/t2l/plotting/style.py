"""How every figure looks, and how it is written."""

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import (
    LogFormatterMathtext,
    LogFormatterSciNotation,
    LogLocator,
    MaxNLocator,
    NullFormatter,
)

from t2l.artefacts import whole
from t2l.names import heading

# Okabe and Ito (2008): told apart by readers with any colour vision
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")

DPI = 200  # format: of PNG: sharp where a page shows 100 points an inch
MOST_CHARACTERS = 40  # of a name in a figure
_RAISED = str.maketrans("-−0123456789", "⁻⁻⁰¹²³⁴⁵⁶⁷⁸⁹")

_SETTINGS = {
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.labelsize": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.prop_cycle": matplotlib.cycler(color=COLOURS),
    "figure.constrained_layout.use": True,
    "legend.frameon": False,
    "pdf.fonttype": 42,
    # names of recordings and joints are no formulas
    "text.parse_math": False,
}


@contextmanager
def styled() -> Iterator[None]:
    """Draw in t2l's style."""
    with plt.rc_context(_SETTINGS):
        yield


def write(figure: Figure, paths: Sequence[Path | str], dpi: float = DPI) -> None:
    """Write a figure to every path, each whole, in the format its suffix names.

    Args:
        dpi: points an inch of PNG.

    Raises:
        OutputError: a file cannot be written.
    """
    _write_powers_out(figure)
    for path in paths:
        # without dates, the same figure is the same file
        metadata = {"CreationDate": None} if str(path).endswith(".pdf") else None
        drawn = BytesIO()
        # in memory: on a full disk matplotlib fails while it fails, and hides what happened.
        # With a resolution: where figures are written, the style's settings hold no more
        kind = Path(path).suffix.removeprefix(".")
        figure.savefig(drawn, format=kind, metadata=metadata, dpi=dpi)
        with whole(path) as draft:
            draft.write_bytes(drawn.getvalue())
    plt.close(figure)


def raised(number: str) -> str:
    """An exponent in the characters for it, where text is no formula."""
    return number.translate(_RAISED)


class _Powers(LogFormatterSciNotation):
    """Powers of ten in plain text, where text is no formula."""

    def __call__(self, x: float, pos: int | None = None) -> str:
        text = super().__call__(x, pos)
        text = re.sub(r"\^\{(.*?)\}", lambda power: raised(power[1]), text)
        return re.sub(r"\$\\mathdefault\{(.*)\}\$", r"\1", text).replace(r"\times", "×")


def _write_powers_out(figure: Figure) -> None:
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            if isinstance(axis.get_major_formatter(), LogFormatterMathtext):
                axis.set_major_formatter(_Powers())
            if isinstance(axis.get_minor_formatter(), LogFormatterMathtext):
                axis.set_minor_formatter(_Powers(labelOnlyBase=False))


def plain_ticks(*axes: Axis) -> None:
    """Label logarithmic axes by plain numbers, as many as their ends are apart.

    Powers of ten from a factor of 100 on; below it 3 too, below 30 instead 2 and 5, and below 4
    whatever is round.
    """
    for axis in axes:
        low, high = axis.get_view_interval()
        within = (1, 2, 5) if high < 30 * low else (1, 3) if high < 100 * low else (1,)
        axis.set_major_locator(MaxNLocator(2) if high < 4 * low else LogLocator(subs=within))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter(NullFormatter())


def shown(name: str) -> str:
    """A name that a person gave, as a figure shows it: in one line, and not too long."""
    text = "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in name)
    if len(text) <= MOST_CHARACTERS:
        return text
    half = MOST_CHARACTERS // 2
    return f"{text[:half]}…{text[1 - half :]}"


def short(names: Sequence[str]) -> dict[str, str]:
    """Names, as `shown`, without the words that all of them begin or end with.

    `fr3_joint1`, `fr3_joint2` become joint1, joint2; `elbow_joint`, `wrist_1_joint` elbow, wrist_1;
    `q.left/a1`, `q.left/a2`, `q.right/a1` left/a1, left/a2, right/a1.
    """
    words = [re.split(r"(?<=[_./])", name) for name in names]
    least = min(map(len, words), default=1)
    first = next((i for i in range(least) if len({w[i] for w in words}) > 1), least)
    last = next((i for i in range(least) if len({w[-1 - i] for w in words}) > 1), least)
    parts = ("".join(w[first : len(w) - last]).rstrip("_./") for w in words)
    return {name: shown(part or name) for name, part in zip(names, parts, strict=True)}


def title(name: str) -> str:
    """A task's name as a heading."""
    return shown(heading(name))


def plain(value: float) -> str:
    """A gain as a tick label."""
    return f"{value:g}"
