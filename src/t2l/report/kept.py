"""The scoreboard and its counts on pages of the documentation, from kept tables."""

import re
from pathlib import Path

import pandas as pd

from t2l.scoreboard.table import counts, printable_scoreboard
from t2l.stats.verdict import Verdict

SHOWN = ["Statement", "Section", "The study", "Ours", "n", "p", "Verdict"]
# how pages tell the counts; the last word may be a link
COUNTS = re.compile(
    r"of(\s+)\d+ statements(\s+)\d+ are reproduced,(\s+)\d+ are(\s+)not,(\s+)\d+ cannot be told,"
    r"(\s+(?:and\s+)?)\d+ are",
    re.IGNORECASE,
)


def judged(table: pd.DataFrame) -> str:
    """The rows that were judged, as Markdown."""
    printed = printable_scoreboard(table)[table.verdict != Verdict.NOT_RUN][SHOWN]
    return printed.to_markdown(index=False, disable_numparse=True)


def open_statements(table: pd.DataFrame) -> str:
    """The rows that were not, as a list."""
    rows = table[table.verdict == Verdict.NOT_RUN]
    return "\n".join(f"- {statement.removesuffix('.')}" for statement in rows.statement)


def with_counts(text: str, table: pd.DataFrame) -> str:
    """A page's text whose counts of verdicts are those of the table."""
    found = counts(table)
    numbers = [len(table), *(found.get(str(verdict), 0) for verdict in Verdict)]

    def told(match: re.Match[str]) -> str:
        number = iter(numbers)
        return re.sub(r"\d+", lambda _: str(next(number)), match[0])

    return COUNTS.sub(told, text)


def with_tables(text: str, table: pd.DataFrame) -> str:
    """The scoreboard's page, its table and list replaced."""
    text = re.sub(r"^\| Statement .*?\n(?=\n)", judged(table) + "\n", text, flags=re.M | re.S)
    return re.sub(
        r"(?<=\n### Open\n\n)(.*?\n\n)- .*?\n(?=\n## )",
        lambda match: match[1] + open_statements(table) + "\n",
        text,
        flags=re.S,
    )


def write_pages(root: Path, table: pd.DataFrame) -> None:
    """Bring README.md and docs/scoreboard.md up to the table."""
    for name, change in (
        ("README.md", with_counts),
        ("docs/scoreboard.md", lambda text, rows: with_counts(with_tables(text, rows), rows)),
    ):
        path = root / name
        path.write_text(change(path.read_text(encoding="utf-8"), table), encoding="utf-8")
