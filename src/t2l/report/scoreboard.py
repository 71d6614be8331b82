"""The scoreboard as a page: what each verdict rests on, one claim below the other."""

import re
from collections.abc import Sequence
from importlib.resources import files

import pandas as pd
from markupsafe import Markup, escape

from t2l.report.templating import templates
from t2l.stats.verdict import Verdict
from t2l.study.scoreboard.table import CHAINS, counts, printable_scoreboard
from t2l.study.scoreboard.weight import independent

LONGEST_WORD = 20  # format: characters that the narrowest column of text holds


def render(table: pd.DataFrame, studies: Sequence[str], robot: str) -> str:
    """One HTML file that needs nothing but a browser.

    Args:
        table: as `t2l.study.scoreboard.table.scoreboard` makes it.
        studies: of t2l, whose results were read.
        robot: the name of the robot that they are of.
    """
    environment = templates({"breakable": breakable})
    printed = printable_scoreboard(table).rename(columns=str.lower)
    rows = table.assign(shown=printed.ours, shown_p=printed.p).to_dict("records")
    return environment.get_template("scoreboard.html").render(
        chains={name: [row for row in rows if row["chain"] == name] for name in CHAINS},
        counts=counts(table),
        independent=independent(table),
        verdicts=[str(verdict) for verdict in Verdict],
        studies=list(studies),
        robot=robot,
        style=_template("page.css"),
        tables=_template("tables.js"),
    )


def breakable(text: str) -> Markup:
    """Text of which no word is broken: one too long for a column behind slashes and underscores.

    A browser breaks behind a hyphen too, and so within 6.9e-231: what has a digit stays whole.
    """
    return Markup(" ").join(_whole(word) for word in text.split(" "))


def _whole(word: str) -> Markup:
    if len(word) > LONGEST_WORD:
        return Markup(re.sub(r"(?<=.)([/_]+)(?=.)", r"\1<wbr>", str(escape(word))))
    if re.search(r"\d", word) and "-" in word:
        return Markup('<span class="whole">{}</span>').format(word)
    return escape(word)


def _template(name: str) -> Markup:
    return Markup((files("t2l.report") / "templates" / name).read_text())
