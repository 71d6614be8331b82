"""What the documentation shows, made of the tables that the repository keeps in docs/data.

`python -m t2l.report.kept` brings the documentation up to its data; the workflow's target
`published` writes the same into results/published.
"""

import re
from collections.abc import Iterator
from pathlib import Path

import pandas as pd
import yaml

from t2l.artefacts import write_text
from t2l.config.models.experiment import TransferDecision
from t2l.figures.kept import DPI, FIGURES
from t2l.plotting.style import write
from t2l.report.scoreboard import render
from t2l.stats.collections import printable_collections
from t2l.stats.verdict import Verdict
from t2l.study.kept.evidence import evidence
from t2l.study.kept.tables import collections, compliance, printable_compliance, tables
from t2l.study.scoreboard.table import counts, printable_scoreboard, scoreboard, to_latex
from t2l.study.scoreboard.weight import by_finding, contestable, independent
from t2l.study.transfer.rule import Rule

PAGES = (
    "README.md", "docs/scoreboard.md", "docs/scoreboard_rules.md", "docs/results_collections.md",
)  # fmt: skip
ROBOT = "fr3"
SHOWN = ["Statement", "Section", "The study", "Ours", "n", "p", "Verdict"]
# how pages tell the counts; the last word may be a link
COUNTS = re.compile(
    r"of(\s+)\d+ statements(\s+)\d+ are reproduced,(\s+)\d+ are(\s+)not,(\s+)\d+ cannot be told,"
    r"(\s+(?:and\s+)?)\d+ are",
    re.IGNORECASE,
)
INDEPENDENT = re.compile(
    r"\d+(\s+rows\s+that\s+are\s+reproduced\s+are\s+)\d+(\s+independent\s+findings)"
)
CONTESTABLE = re.compile(r"In(\s+)\d+(\s+of\s+them\s+another\s+verdict\s+was\s+possible)")


def registered(path: Path) -> Rule:
    """The rule on transfer that a study's configuration registers."""
    section = yaml.safe_load(path.read_text(encoding="utf-8"))["transfer_decision"]
    return Rule(**TransferDecision(**section).model_dump())


def judged(table: pd.DataFrame) -> pd.DataFrame:
    """The rows of a scoreboard that were judged, as text."""
    return printable_scoreboard(table)[table.verdict != Verdict.NOT_RUN][SHOWN]


def printable_findings(table: pd.DataFrame) -> pd.DataFrame:
    """`t2l.study.scoreboard.weight.by_finding` as text, of what was judged."""
    found = by_finding(table)
    found = found[found["rows"] > found[str(Verdict.NOT_RUN)]]
    shown = {str(verdict).capitalize(): str(verdict) for verdict in list(Verdict)[:3]}
    return pd.DataFrame(
        {
            "Finding": found.finding,
            **{head: [str(n or "") for n in found[key]] for head, key in shown.items()},
            "Reproduced, with a number in the study": [str(n or "") for n in found.numbers],
            "… where another verdict was possible": [str(n or "") for n in found.contestable],
            "Rows are one, as they rest on": found.why,
        }
    )


def printable_weights(table: pd.DataFrame) -> pd.DataFrame:
    """What speaks against single rows that were judged, as text."""
    told = (table.verdict != Verdict.NOT_RUN) & (
        (table.foreseeable != "") | (table.afterwards != "")
    )
    rows = table[told]
    return pd.DataFrame(
        {
            "Row": rows.statement,
            "Another verdict was hardly possible": rows.foreseeable,
            "Written or changed after data had been seen": rows.afterwards,
        }
    )


def open_statements(table: pd.DataFrame) -> str:
    """The rows that were not, as a list."""
    rows = table[table.verdict == Verdict.NOT_RUN]
    return "\n".join(f"- {statement.removesuffix('.')}" for statement in rows.statement)


def with_counts(text: str, table: pd.DataFrame) -> str:
    """A page's text whose counts of verdicts and findings are those of the scoreboard."""
    found = counts(table)
    numbers = [len(table), *(found.get(str(verdict), 0) for verdict in Verdict)]

    def told(match: re.Match[str]) -> str:
        number = iter(numbers)
        return re.sub(r"\d+", lambda _: str(next(number)), match[0])

    text = COUNTS.sub(told, text)
    text = CONTESTABLE.sub(lambda match: f"In{match[1]}{contestable(table)}{match[2]}", text)
    reproduced = found.get(str(Verdict.REPRODUCED), 0)
    return INDEPENDENT.sub(
        lambda match: f"{reproduced}{match[1]}{independent(table)}{match[2]}", text
    )


def with_tables(text: str, table: pd.DataFrame, folder: Path) -> str:
    """A page whose tables and list are those of the scoreboard, where it has them.

    Args:
        folder: docs/data.
    """
    for printed in (
        judged(table), printable_findings(table), printable_weights(table),
        printable_compliance(compliance(folder)), printable_collections(collections(folder)),
    ):  # fmt: skip
        head = re.escape(printed.columns[0])
        shown = printed.to_markdown(index=False, disable_numparse=True)
        text = re.sub(
            rf"^\| {head} .*?\n(?=\n)",
            lambda _, shown=shown: f"{shown}\n",
            text,
            flags=re.M | re.S,
        )
    return re.sub(
        r"(?<=\n### Open\n\n)(.*?\n\n)- .*?\n(?=\n## |\Z)",
        lambda match: match[1] + open_statements(table) + "\n",
        text,
        flags=re.S,
    )


def pages(root: Path, table: pd.DataFrame) -> Iterator[tuple[str, str]]:
    """Each page that tells of the scoreboard, by its path, and what it is to say.

    Args:
        root: of the repository.
    """
    for name in PAGES:
        text = (root / name).read_text(encoding="utf-8")
        yield name, with_counts(with_tables(text, table, root / "docs/data"), table)


def write_all(folder: Path, rule: Rule, root: Path, out: Path) -> None:
    """Scoreboard, tables, figures and pages, below `out`.

    Args:
        folder: docs/data.
        root: of the repository, whose pages are brought up to the data.
    """
    kept = evidence(folder, rule)
    board = scoreboard(kept)
    printed = printable_scoreboard(board)
    write_text(board.to_csv(index=False), out / "scoreboard.csv")
    write_text(_markdown(printed), out / "scoreboard.md")
    write_text(to_latex(printed), out / "scoreboard.tex")
    write_text(_markdown(printable_findings(board)), out / "findings.md")
    write_text(render(board, kept.studies, ROBOT), out / "scoreboard.html")
    for name, table, text in tables(folder, rule):
        write_text(table.to_csv(index=False), out / "tables" / f"{name}.csv")
        write_text(_markdown(text), out / "tables" / f"{name}.md")
    for name, draw in FIGURES.items():
        paths = [out / "figures" / f"{name}.{suffix}" for suffix in ("pdf", "png")]
        write(draw(folder), paths)
    for name, text in pages(root, board):
        write_text(text, out / "pages" / name)


def write_documentation(root: Path) -> None:
    """Bring pages and figures of the documentation up to its data."""
    folder = root / "docs/data"
    rule = registered(root / "config/studies/transfer_decision.yaml")
    for name, text in pages(root, scoreboard(evidence(folder, rule))):
        write_text(text, root / name)
    for name, draw in FIGURES.items():
        write(draw(folder), [root / "docs" / f"{name}.png"], dpi=DPI.get(name, DPI[""]))


def _markdown(printed: pd.DataFrame) -> str:
    return printed.to_markdown(index=False, disable_numparse=True) + "\n"


if __name__ == "__main__":
    write_documentation(Path())
