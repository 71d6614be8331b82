"""Which study a claim is judged by, where results of several are read."""

from itertools import permutations

import numpy as np
import pandas as pd
import pytest
import yaml

from t2l.config.study import read_study
from t2l.stats.collections import FEWEST, UNIT
from t2l.stats.verdict import Verdict
from t2l.study.claim import nothing
from t2l.study.cloning import ablations
from t2l.study.cloning import claims as cloning
from t2l.study.evidence import AbsentError, AmbiguousError, Evidence
from t2l.study.published.numbers import splits
from t2l.study.scoreboard.table import CHAINS, scoreboard
from t2l.study.transfer import claims as transfer
from tests.conftest import ROOT
from tests.study import planted
from tests.study.judged import CLAIMS

SHIPPED = {path.stem: yaml.safe_load(path.read_text()) for path in ROOT.glob("config/studies/*")}
# their judges take each part from the study that is about it
JOINT = {"pooled_slopes", "ablation_classes"}
# judged by recordings of other people's robots, which no study of ours makes
RECORDED = {"stiff_datasets"}
NOMINAL = "block_stack__nominal__cells"


def better(share):
    return {NOMINAL: planted.cloning(CO=share)}


def of(**studies):
    """The results of several studies, in this order."""
    return Evidence(
        [read for study, tables in studies.items() for read in planted.read(study, tables)]
    )


def test_a_claim_that_is_judged_names_a_study_that_ships():
    for key, claim in CLAIMS.items():
        named = claim.judge is not nothing and key not in JOINT | RECORDED
        assert bool(claim.about) == named, key
        assert not named or claim.about in SHIPPED, key
    assert all(name == entry["study"] for name, entry in SHIPPED.items())


def test_the_documentation_names_it_too():
    section = (
        (ROOT / "docs/scoreboard_rules.md").read_text().split("\n## Which results are read\n")[1]
    )
    cells = [row.split("|")[2] for row in section.splitlines() if row.startswith("|")]
    for claim in CLAIMS.values():
        assert not claim.about or any(f"`{claim.about}`" in cell for cell in cells), claim.key


def test_the_study_that_is_named_makes_what_is_read():
    for _, variant, study in ablations.VARIANTS.values():
        assert variant in SHIPPED[study]["variants"]
    for variant, study in list(ablations.CLASSES.items())[1:]:
        assert variant in SHIPPED[study]["variants"]
    for task, study in cloning.STUDY_TASKS.items():
        assert task in SHIPPED[study].get("tasks", ["block_stack"])
    read = [(name, study) for name, (_, study) in transfer.CONDITIONS.items()]
    read += [(name, transfer.RATED) for name in transfer.RATES]
    for name, study in [*read, ("joint_reach", CLAIMS["landscape"].about)]:
        assert name in [one["name"] for one in SHIPPED[study]["sim_to_real"]["conditions"]]


@pytest.mark.parametrize("order", list(permutations(["cloning_grid", "another", "third"])))
def test_the_study_that_a_claim_is_about_counts_wherever_it_stands(order):
    shares = {"cloning_grid": 0.8, "another": 0.3, "third": 0.3}
    found = CLAIMS["co_block_stack"].finding(of(**{name: better(shares[name]) for name in order}))
    assert (found.verdict, found.results) == (Verdict.REPRODUCED, "cloning_grid")


def drawn_anew(count, share):
    names = ["block_stack", *(f"block_stack__collection{i}" for i in range(1, count))]
    return {
        f"{name}__nominal__cells": planted.cloning(CO=share + 0.01 * i)
        for i, name in enumerate(names)
    }


@pytest.mark.parametrize("key", ["co_block_stack", "compliant_once_overdamped", "damping_helps"])
def test_collections_drawn_anew_are_the_unit_where_there_are_five(key):
    one, five, four = better(0.8), drawn_anew(5, 0.7), drawn_anew(4, 0.7)
    found = CLAIMS[key].finding(of(cloning_grid=one, collections=five))
    assert (found.verdict, found.n, found.results) == (Verdict.REPRODUCED, 5, "collections")
    assert np.isnan(found.p)
    assert found.unit.startswith("collection")
    board = scoreboard(of(cloning_grid=one, collections=five)).set_index("id")
    assert (board.unit[key], board.n[key]) == (found.unit, 5)
    found = CLAIMS[key].finding(of(cloning_grid=one, collections=four))
    assert (found.results, found.unit) == ("cloning_grid", "")
    board = scoreboard(of(cloning_grid=one, collections=four)).set_index("id")
    assert board.unit[key].startswith("cell")


@pytest.mark.parametrize(
    ("key", "task"), [("co_unloading", "dishrack_unloading"), ("co_dishwasher", "dishwasher")]
)
def test_collections_of_other_tasks_are_their_unit_too(key, task):
    study = CLAIMS[key].anew
    assert SHIPPED[study]["collections"] >= FEWEST
    assert task in SHIPPED[study]["tasks"]
    names = [task, *(f"{task}__collection{i}" for i in range(1, FEWEST))]
    anew = {
        f"{name}__nominal__cells": planted.cloning(CO=0.7 + 0.01 * i)
        for i, name in enumerate(names)
    }
    one = {f"{task}__nominal__cells": planted.cloning()}
    found = CLAIMS[key].finding(of(**{cloning.STUDY_TASKS[task]: one, study: anew}))
    assert (found.verdict, found.n) == (Verdict.REPRODUCED, FEWEST)
    assert (found.results, found.unit) == (study, UNIT)


def test_collections_that_disagree_tell_nothing_however_many_cells_they_have():
    shares = (0.1, 0.9, 0.2, 0.8, 0.5)
    tables = drawn_anew(5, 0.0)
    tables = {name: planted.cloning(CO=share) for name, share in zip(tables, shares, strict=True)}
    found = CLAIMS["compliant_once_overdamped"].finding(of(collections=tables))
    assert found.verdict is Verdict.CANNOT_TELL


def test_a_study_of_one_s_own_needs_no_name():
    claim = CLAIMS["co_block_stack"]
    found = claim.finding(of(mine=better(0.8)))
    assert (found.verdict, found.results) == (Verdict.REPRODUCED, "mine")
    # others, which have other things, or nothing in this table, do not change that
    others = {"block_stack__chunk_1__cells": planted.cloning()}
    empty = {NOMINAL: planted.cloning()[:0]}
    found = claim.finding(of(ablations=others, cloning_grid=empty, mine=better(0.8)))
    assert (found.verdict, found.results) == (Verdict.REPRODUCED, "mine")


@pytest.mark.parametrize("order", list(permutations(["mine", "yours", "ablations"])))
def test_of_two_others_none_is_taken(order):
    chunks = {"block_stack__chunk_1__cells": planted.cloning()}
    have = {"mine": better(0.8), "yours": better(0.3), "ablations": chunks}
    found = CLAIMS["co_block_stack"].finding(of(**{name: have[name] for name in order}))
    assert found.verdict is Verdict.CANNOT_TELL
    assert found.ours == "mine and yours have it, and none of them is cloning_grid"
    assert np.isnan(found.p)
    assert not found.n


def test_rollouts_and_policies_are_of_the_same_study():
    """Two studies with one condition: one has trials, both have policies, one was deployed."""
    folder = "sim_to_real__joint_reach"
    corners = planted.frame(planted.CORNERS, "transfer", success_sim_100=0.0)
    trials = planted.frame(planted.CORNERS, "transfer", state="complete", success=0.5)
    searched = {
        f"{folder}__cells": corners,
        f"{folder}__kp16_kd2__trials": pd.concat([trials] * 20, ignore_index=True),
    }
    deployed = planted.deployed("joint_reach", slope=0.5)
    both = {"landscape": searched, "transfer_decision": deployed}
    for order in permutations(both):
        evidence = of(**{name: both[name] for name in order})
        # with the policies of the search, none of which works, nothing would be left to judge
        assert CLAIMS["transfer_joint_reach"].finding(evidence).verdict is Verdict.REPRODUCED
        assert CLAIMS["landscape"].finding(evidence).n == 80
        assert CLAIMS["existence_joint_reach"].finding(evidence).verdict is Verdict.NOT_REPRODUCED


def test_parts_of_a_joint_claim_come_from_the_study_about_each():
    def tables(*tasks, **shares):
        return {f"{task}__nominal__cells": planted.cloning(**shares) for task in tasks}

    trend = {"CO": 0.8, "SO": 0.6, "CU": 0.5}
    tasks, claim = cloning.STUDY_TASKS, CLAIMS["pooled_slopes"]
    apart = {study: {} for study in tasks.values()}
    for task, study in tasks.items():
        apart[study] |= tables(task, **trend)
    other = {"variants": tables(*list(tasks)[:1])}
    for studies in (apart | other, other | apart, {"paper": tables(*tasks, **trend)}):
        assert claim.finding(of(**studies)).verdict is Verdict.REPRODUCED
    unclear = claim.finding(of(mine=tables(*tasks), yours=tables(*tasks)))
    assert unclear.verdict is Verdict.CANNOT_TELL


def test_the_whole_scoreboard_is_the_same_in_any_order():
    attenuated = planted.cloning(CO=0.8, loss=lambda table: 1e-3 * table.kd / table.kp)
    identified = planted.frame(planted.TRANSFER, "transfer", s_star=lambda kp, kd, _: 1 / (kp + kd))
    have = {
        "cloning_grid": {NOMINAL: attenuated},
        "variants": {NOMINAL: attenuated, "block_stack__history_1__cells": planted.cloning()},
        "transfer_decision": planted.deployed("joint_reach", slope=0.5),
        "mine": planted.deployed("joint_reach") | {"sim_to_real__identification": identified},
    }
    tables = [
        scoreboard(of(**{name: have[name] for name in order}))
        for order in (have, reversed(have), sorted(have))
    ]
    for table in tables[1:]:
        pd.testing.assert_frame_equal(table, tables[0])
    results = tables[0].set_index("id").results
    assert results["slopes_joint_reach"] == "transfer_decision"
    # the study that deployed did not identify
    assert results["inverse_relation"] == "mine"


def test_one_study_has_all_or_it_is_said_what_it_lacks():
    def make(one):
        return one.table("cloning", ("success",), variant="nominal").success.max()

    several = of(mine=better(0.8), cloning_grid={"block_stack__chunk_1__cells": planted.cloning()})
    assert several.of_one("cloning_grid", make) > 0.8
    with pytest.raises(AmbiguousError, match="have it, and none of them is cloning_grid"):
        of(mine=better(0.8), yours=better(0.8)).of_one("cloning_grid", make)
    with pytest.raises(AbsentError, match="no table of nominal cloning"):
        several.only("cloning_grid").of_one("cloning_grid", make)
    with pytest.raises(AbsentError, match="no results"):
        of().of_one("cloning_grid", make)


def test_studies_divide_their_grids_as_the_scoreboard_does():
    for name, entry in SHIPPED.items():
        study = read_study(entry, ROOT / "config")
        for grid, chain in ((study.grid, "cloning"), (study.recording_grid, "transfer")):
            split = splits()[chain]
            for cell in grid.cells:
                assert grid.region(cell) == split.regions([cell.kp], [cell.kd])[0], (name, cell)


def test_what_is_judged_of_reinforcement_learning_has_the_study_s_reward():
    named = {"joint_reach", *transfer.CONDITIONS, *transfer.RATES}
    judged = [*CHAINS["Reinforcement learning"], *CHAINS["Transfer"]]
    for study in {claim.about for claim in judged if claim.about}:
        for condition in SHIPPED[study]["sim_to_real"]["conditions"]:
            if condition["name"] in named:
                task = yaml.safe_load((ROOT / f"config/tasks/{condition['task']}.yaml").read_text())
                assert task["reward"] == "isaaclab", (study, condition["name"])


@pytest.mark.parametrize(
    ("key", "falls"),
    [("loss_misleads", False), ("effective_error", True), ("compliant_loss_higher", None)],
)
def test_what_tells_success_is_judged_in_each_collection(key, falls):
    def loss(table):
        return 1e-3 * (1 + (table.kp <= 128)) * np.exp(table.success)

    names = ["block_stack", *(f"block_stack__collection{i}" for i in range(1, 5))]
    tables = {
        f"{name}__nominal__cells": planted.cloning(loss=loss, CO=0.6 + 0.02 * i, SU=0.1)
        for i, name in enumerate(names)
    }
    found = CLAIMS[key].finding(of(collections=tables))
    assert (found.verdict, found.n) == (Verdict.REPRODUCED, 5)
    if falls is not None:
        assert (found.value < 0) == falls
