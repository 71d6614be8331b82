"""The scoreboard as a page: what each verdict rests on, one claim below the other."""

from collections.abc import Sequence
from importlib.resources import files

import pandas as pd
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from t2l.scoreboard.table import CHAINS, counts, printable_scoreboard
from t2l.stats.verdict import Verdict


def render(table: pd.DataFrame, studies: Sequence[str], robot: str) -> str:
    """One HTML file that needs nothing but a browser.

    Args:
        table: as `t2l.scoreboard.table.scoreboard` makes it.
        studies: of t2l, whose results were read.
        robot: the name of the robot that they are of.
    """
    environment = Environment(
        loader=PackageLoader("t2l.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    printed = printable_scoreboard(table).rename(columns=str.lower)
    rows = table.assign(shown=printed.ours, shown_p=printed.p).to_dict("records")
    return environment.get_template("scoreboard.html").render(
        chains={name: [row for row in rows if row["chain"] == name] for name in CHAINS},
        counts=counts(table),
        verdicts=[str(verdict) for verdict in Verdict],
        studies=list(studies),
        robot=robot,
        style=Markup((files("t2l.report") / "templates" / "page.css").read_text()),
    )
