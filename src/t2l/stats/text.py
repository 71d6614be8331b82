"""Numbers of tables as people read them, and tables as LaTeX."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd

from t2l.artefacts import write_text


def rate(share: float) -> str:
    """A share as a percentage."""
    return "no cells" if pd.isna(share) else f"{100 * share:.1f} %"


def estimate(value: float, error: float) -> str:
    """A coefficient with its standard error."""
    return "undetermined" if pd.isna(value) else f"{value:+.3f} ± {error:.3f}"


def interval(value: float, low: float, high: float, digits: int = 2) -> str:
    """A value with the ends of its interval."""
    if pd.isna(value):
        return "undetermined"
    ends = "too few cells" if pd.isna(low) else f"{low:+.{digits}f} to {high:+.{digits}f}"
    return f"{value:+.{digits}f} ({ends})"


def p_value(p: float) -> str:
    """A p value."""
    return "undetermined" if pd.isna(p) else ("< 0.001" if p < 0.001 else f"{p:.3f}")


def p_over_cells(p: float) -> str:
    """A p value that is only known where the design can attain its level."""
    return "cannot be told" if pd.isna(p) else p_value(p)


def latex(printed: pd.DataFrame, headers: Mapping[str, str]) -> str:
    """A booktabs tabular of a table of text, with some headers replaced by LaTeX of their own."""
    marks = {"±": r"$\\pm$", "< ": r"$<$ ", r"([+-])(\d)": r"$\1$\2"}
    cells = printed.replace({r"([%_&#])": r"\\\1", **marks}, regex=True)
    columns = "l" + "r" * (len(printed.columns) - 1)
    escaped = {name: re.sub(r"([%_&#])", r"\\\1", name).replace("^", r"\^{}") for name in printed}
    return cells.rename(columns={**escaped, **headers}).to_latex(index=False, column_format=columns)


def write_printed(
    table: pd.DataFrame,
    printed: pd.DataFrame,
    paths: Sequence[Path | str],
    headers: Mapping[str, str] | None = None,
) -> None:
    """Write a table's numbers as CSV, and as people read them as Markdown and LaTeX.

    Args:
        printed: the same as text.
        paths: of the three files, in this order.
        headers: see `latex`.
    """
    csv, markdown, tex = paths
    write_text(table.to_csv(index=False), csv)
    write_text(printed.to_markdown(index=False, disable_numparse=True) + "\n", markdown)
    write_text(latex(printed, headers or {}), tex)
