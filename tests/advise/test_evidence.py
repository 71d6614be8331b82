"""What the page and docs/advise.md quote is what the benchmark wrote."""

import pytest

from t2l.advise.evidence import OTHER, OURS, STUDY, evidence, mean_of
from tests.conftest import ROOT

PAGE = (ROOT / "docs/advise.md").read_text()


@pytest.mark.parametrize(
    ("row", "key", "percent"),
    [
        ("ρ with success, this order", "rho", False),
        ("ρ, Kd/Kp", "rho_ratio", False),
        ("ρ, nearness to critical damping", "rho_critical", False),
        ("ρ, the compliant and overdamped region", "rho_compliant", False),
        ("success of the best pair", "best", True),
        ("success of the pair named, by this order", "advised", True),
        ("by Kd/Kp", "ratio", True),
        ("of pairs nearest to critical damping, mean", "critical", True),
    ],
)
def test_the_table_is_the_evidence(row, key, percent):
    (line,) = [line for line in PAGE.splitlines() if line.startswith(f"| {row} |")]
    for cell, whose in zip(line.split("|")[2:4], (OURS, STUDY), strict=True):
        value = mean_of(evidence().of(whose), key)
        assert cell.split()[0] == (f"{100 * value:.0f}" if percent else f"{value:.2f}")


def test_sentences_are_the_evidence():
    text = " ".join(PAGE.split())
    (other,) = evidence().of(OTHER)
    assert f"the order has ρ {other.rho:.2f}, Kd/Kp has {other.rho_ratio:.2f}" in text
    rights = [f"{100 * pair.right:.0f} %" for pair in evidence().pairs]
    said = "{} if they differ by up to a quarter, {} up to a factor of 1.6, {} up to 2.5, "
    assert (said + "{} up to 4 and {} beyond").format(*rights) in text
    trials = evidence().trials
    inside = [f"{100 * one.inside_succeeded:.0f}" for one in trials]
    outside = [f"{100 * one.outside_succeeded:.0f}" for one in trials]
    numbers = [str(one.inside) for one in trials]
    assert (
        "range {}, {} and {} % succeeded ({}, {} and {} of them)".format(*inside, *numbers) in text
    )
    assert "of the others {}, {} and {} %".format(*outside) in text
    for key in ("trained", "trained_at_random"):
        named = [f"{100 * mean_of(evidence().of(w), key):.0f}" for w in (OURS, STUDY, OTHER)]
        assert all(number in text for number in named)
    assert not any(row.best_rings for row in evidence().grids)


def test_the_planted_worlds_are_the_evidence():
    lines = [line.split("|") for line in PAGE.splitlines() if line.startswith("| ")]
    told = {cells[1].strip(): [cell.strip() for cell in cells[2:4]] for cells in lines}
    both = [
        [row for row in evidence().planted if row.known == known]
        for known in ("nominal", "explained")
    ]
    nominal, explained = both
    within = told["within 5 points of the best pair: advice that knows the effects, their "
                  "numbers off by 5 %"]  # fmt: skip
    assert within == [str(row.within) for row in explained]
    lost = told["points of success lost, mean: advice that knows the effects"]
    assert lost == [f"{100 * row.lost:.1f}".replace("-", "−") for row in explained]
    ruled = told["by advice that knows the nominal robot alone"]
    assert ruled == [f"{row.ruled_out}, {row.failed}" for row in nominal]
    assert told["the largest Kd/Kp"] == [str(row.ratio_within) for row in explained]


def test_what_trainings_settle_is_the_evidence():
    text = " ".join(PAGE.split())
    lost = {row.trainings: 100 * row.lost for row in evidence().settling}
    said = (
        f"loses {lost[0]:.1f} per cent points against the best without trainings, {lost[1]:.1f} "
        f"after one, {lost[4]:.1f} after four and {lost[8]:.1f} after eight"
    )
    assert said in text
