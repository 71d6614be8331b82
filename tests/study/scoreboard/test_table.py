import pandas as pd
import pytest

from t2l.report.scoreboard import render
from t2l.stats.verdict import Verdict
from t2l.study.published.numbers import claims
from t2l.study.scoreboard.table import (
    CHAINS,
    COLUMNS,
    counts,
    printable_scoreboard,
    scoreboard,
    to_latex,
)
from tests.study.judged import CLAIMS, NOT_RUN, verdict
from tests.study.planted import cloning, evidence


def test_every_claim_has_its_number_and_every_number_its_claim():
    keys = [claim.key for chain in CHAINS.values() for claim in chain]
    assert len(keys) == len(set(keys))
    assert set(keys) == set(claims())


def test_a_claim_with_a_test_says_its_unit_and_rule():
    for chain in CHAINS.values():
        for claim in chain:
            assert claim.statement.endswith("."), claim.key
            if claim.rule:
                assert claim.unit, claim.key


def test_the_table_has_a_row_a_claim_and_prints_no_p_that_says_nothing():
    table = scoreboard(evidence(block_stack__nominal__cells=cloning(CO=0.8)))
    assert tuple(table.columns) == COLUMNS
    assert counts(table)["not run"] == (table.verdict == Verdict.NOT_RUN).sum()
    printed = printable_scoreboard(table)
    row = printed[table.id == "co_block_stack"].iloc[0]
    assert row.Verdict == "reproduced"
    assert row["n"] == "16"
    assert row.Unit == "cell"
    assert row.p == "0.003"  # 6 / 1820
    assert row.Ours.startswith("81.")
    assert (printed.p[table.verdict == "not run"] == "").all()


def test_the_table_is_latex_too():
    text = to_latex(printable_scoreboard(scoreboard(evidence())))
    assert text.isascii()
    for sign in "%_&":
        assert sign not in text.replace(f"\\{sign}", "").replace(" & ", ""), sign


def test_the_page_escapes_what_it_shows():
    table = scoreboard(evidence())
    table.loc[0, "ours"] = "<script>alert(1)</script>"
    page = render(table, ["<b>mine</b>"], "fr3")
    assert "<script>alert" not in page
    assert "&lt;script&gt;alert(1)" in page
    assert "<b>mine" not in page
    for key in table.id:
        assert f'id="{key}"' in page


def test_the_page_counts_verdicts():
    table = pd.DataFrame(scoreboard(evidence(block_stack__nominal__cells=cloning(CO=0.8))))
    page = render(table, ["mine"], "fr3")
    assert f"<b>{counts(table)['reproduced']}</b><span>reproduced</span>" in page
    row = table[table.id == "co_block_stack"].iloc[0]
    assert f"effect {row.value:+.3g} ({row.lower:+.3g} to {row.upper:+.3g})" in page


@pytest.mark.parametrize("key", sorted(CLAIMS))
def test_without_results_every_claim_is_not_run(key):
    assert verdict(key) is NOT_RUN
