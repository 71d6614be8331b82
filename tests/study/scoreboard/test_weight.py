from collections import Counter

import pandas as pd
import pytest

from t2l.report.kept import registered
from t2l.report.scoreboard import render
from t2l.stats.verdict import Verdict
from t2l.study.attenuation.claims import VARIANCE_COLUMNS
from t2l.study.kept.evidence import evidence as kept
from t2l.study.published.numbers import claims
from t2l.study.scoreboard.table import scoreboard
from t2l.study.scoreboard.weight import (
    AFTERWARDS,
    FINDINGS,
    FORESEEABLE,
    by_finding,
    contestable,
    independent,
)
from tests.conftest import ROOT
from tests.study.planted import CLONING, cloning, evidence


def test_every_row_is_evidence_of_one_finding():
    keys = Counter(key for finding in FINDINGS for key in finding.keys)
    assert set(keys) == set(claims())
    assert set(keys.values()) == {1}
    assert set(AFTERWARDS) | set(FORESEEABLE) <= set(keys)


def test_no_row_that_is_judged_hides_what_chose_its_policies_or_robot():
    """Kept data: how policies are trained, and the robot they run on, followed a null result."""
    rule = registered(ROOT / "config/studies/transfer_decision.yaml")
    table = scoreboard(kept(ROOT / "docs/data", rule))
    judged = table[table.verdict != Verdict.NOT_RUN].set_index("id")
    for key, row in judged.iterrows():
        if row.chain in ("Identification", "Transfer"):
            assert "second version" in row.afterwards, key
        elif "behaviour cloning" in row.finding:
            assert row.afterwards, key
        # where the unit is the collection, when that was decided
        elif row.unit.startswith("collection ("):
            assert "collections" in row.afterwards, key


def test_rows_of_one_contrast_are_one_finding():
    """Damping helps, in every variant and task: twelve rows of it are no twelve findings."""
    damping = cloning(CO=0.8, SO=0.7)
    tables = {"block_stack__nominal__cells": damping, "block_stack_ur5e__nominal__cells": damping}
    tables |= {f"block_stack__{name}__cells": damping for name in ("chunk_1", "rate_10_hz")}
    table = scoreboard(evidence(**tables))
    reproduced = table[table.verdict == Verdict.REPRODUCED]
    assert len(reproduced) >= 5
    found = by_finding(table).set_index("finding")
    assert found.reproduced["Damping helps behaviour cloning"] == len(
        reproduced[reproduced.finding == "Damping helps behaviour cloning"]
    )
    assert independent(table) == reproduced.finding.nunique()
    assert independent(table) < len(reproduced)


def test_a_finding_that_could_hardly_fail_is_not_counted_among_those_that_could():
    """A linear joint beside linear theory: reproduced, and no news."""
    held = pd.DataFrame(
        [("joint", mass, kp, 128, 0.02, 0.01, 1e-6 * kp / 128)
         for mass in (0.1, 1.0) for kp in (32, 128)],
        columns=VARIANCE_COLUMNS,
    )  # fmt: skip
    table = scoreboard(evidence(attenuation__held_noise=held))
    assert (independent(table), contestable(table)) == (1, 0)
    both = {"attenuation__held_noise": held, "block_stack__nominal__cells": cloning(CO=0.8)}
    table = scoreboard(evidence(**both))
    assert contestable(table) == independent(table) - 1


def test_without_results_there_is_no_finding():
    table = scoreboard(evidence())
    assert independent(table) == 0
    assert by_finding(table)["rows"].sum() == len(table)


@pytest.mark.parametrize("key", ["co_block_stack", "ablation_chunk"])
def test_a_row_says_whether_the_study_gives_a_number(key):
    table = scoreboard(evidence(block_stack__nominal__cells=cloning(CLONING))).set_index("id")
    assert table.number[key] == (key == "co_block_stack")


def test_the_page_counts_findings_and_says_what_was_changed_afterwards():
    table = pd.DataFrame(scoreboard(evidence(block_stack__nominal__cells=cloning(CO=0.8))))
    page = render(table, ["mine"], "fr3")
    count = independent(table)
    assert f"are {count} independent" in page
    assert "After data had been seen: 150 epochs" in page
    assert "The study states no number." in page
