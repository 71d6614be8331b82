"""Numbers of tables as people read them, and tables as LaTeX."""

from collections.abc import Mapping

import pandas as pd


def rate(share: float) -> str:
    """A share as a percentage."""
    return "no cells" if pd.isna(share) else f"{100 * share:.1f} %"


def estimate(value: float, error: float) -> str:
    """A coefficient with its standard error."""
    return "undetermined" if pd.isna(value) else f"{value:+.3f} ± {error:.3f}"


def p_value(p: float) -> str:
    """A p value."""
    return "undetermined" if pd.isna(p) else ("< 0.001" if p < 0.001 else f"{p:.3f}")


def p_over_cells(p: float) -> str:
    """A p value that is only known where the design can attain its level."""
    return "cannot be told" if pd.isna(p) else p_value(p)


def latex(printed: pd.DataFrame, headers: Mapping[str, str]) -> str:
    """A booktabs tabular of a table of text, with some headers replaced."""
    cells = printed.replace(
        {"%": r"\\%", "±": r"$\\pm$", "< ": r"$<$ ", r"([+-])(\d)": r"$\1$\2"}, regex=True
    )
    columns = "l" + "r" * (len(printed.columns) - 1)
    escaped = {name: name.replace("%", r"\%").replace("^", r"\^{}") for name in printed.columns}
    return cells.rename(columns={**escaped, **headers}).to_latex(index=False, column_format=columns)
