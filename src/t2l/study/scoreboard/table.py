"""The scoreboard as a table: one row a claim."""

import pandas as pd

from t2l.stats.text import p_value
from t2l.study import datasets, identification, teleoperation
from t2l.study.attenuation import claims as attenuation
from t2l.study.claim import Claim
from t2l.study.cloning import ablations
from t2l.study.cloning import claims as cloning
from t2l.study.decoupling import claims as decoupling
from t2l.study.evidence import Evidence
from t2l.study.landscape import claims as landscape
from t2l.study.scoreboard.weight import AFTERWARDS, FORESEEABLE, OF
from t2l.study.transfer import claims as transfer
from t2l.study.words import shown

CHAINS: dict[str, list[Claim]] = {
    "Gains of public data sets": datasets.CLAIMS,
    "Stiffness of task and controller": decoupling.CLAIMS,
    "Behaviour cloning": cloning.CLAIMS,
    "Variants of behaviour cloning": ablations.CLAIMS,
    "Noise on actions": attenuation.CLAIMS,
    "Teleoperation": teleoperation.CLAIMS,
    "Reinforcement learning": landscape.CLAIMS,
    "Identification": identification.CLAIMS,
    "Transfer": transfer.CLAIMS,
}
COLUMNS = (
    *("chain", "id", "section", "statement", "theirs", "ours", "value", "lower", "upper", "unit"),
    *("n", "rule", "null", "alpha", "tests", "p", "verdict", "note", "results"),
    *("finding", "number", "foreseeable", "afterwards"),
)

# that LaTeX does not read as text
_SIGNS = {
    "−": "-", "²": "^2", "√": r"\surd", "σ": r"\sigma", "δ": r"\delta", "ρ": r"\rho", "·": r"\cdot",
    "α": r"\alpha", "χ": r"\chi", "×": r"\times", "<": "<",
}  # fmt: skip


def scoreboard(evidence: Evidence) -> pd.DataFrame:
    """One row a claim, columns `COLUMNS`; p is NaN where none could reach α."""
    rows = []
    for chain, claims in CHAINS.items():
        for claim in claims:
            published, found = claim.published, claim.finding(evidence)
            rows.append(
                (chain, claim.key, published.section, claim.statement, published.theirs,
                 found.ours, found.value, found.lower, found.upper, found.unit or claim.unit,
                 found.n, claim.rule, claim.null, claim.alpha, claim.tests, found.p,
                 str(found.verdict), published.note, found.results, OF[claim.key].words,
                 published.number, FORESEEABLE.get(claim.key, ""), AFTERWARDS.get(claim.key, ""))
            )  # fmt: skip
    return pd.DataFrame(rows, columns=list(COLUMNS))


def printable_scoreboard(table: pd.DataFrame) -> pd.DataFrame:
    """`scoreboard` as text, without rules and notes."""
    return pd.DataFrame(
        {
            "Statement": table.statement,
            "Section": table.section,
            "The study": table.theirs,
            "Ours": [_ours(row) for row in table.itertuples()],
            "Unit": [unit.split(" (")[0] for unit in table.unit],
            "n": [str(n) if n else "" for n in table.n],
            "p": ["" if pd.isna(p) else p_value(p) for p in table.p],
            "Verdict": table.verdict,
        }
    )


def to_latex(printed: pd.DataFrame) -> str:
    """A booktabs tabular of `printable_scoreboard`'s table, with columns that wrap."""
    columns = "p{5cm}p{2cm}p{4cm}p{3cm}lrrl"
    text = printed.to_latex(index=False, column_format=columns, escape=True)
    for sign, command in _SIGNS.items():
        text = text.replace(sign, f"${command}$")
    return text


def counts(table: pd.DataFrame) -> dict[str, int]:
    """How many claims have each verdict."""
    return {str(k): int(v) for k, v in table.verdict.value_counts().items()}


def _ours(row) -> str:
    if row.ours or pd.isna(row.value):
        return row.ours
    return shown(row.value, row.lower, row.upper)
