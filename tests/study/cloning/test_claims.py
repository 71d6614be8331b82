"""Planted tables come out each way: a trend is found, so is its absence, few cells cannot tell."""

import numpy as np
import pandas as pd
import pytest

from t2l.study.cloning import ablations
from t2l.study.cloning.claims import STUDY_TASKS
from t2l.study.evidence import Evidence
from tests.study.judged import CLAIMS, NO, NOT_RUN, OPEN, YES, verdict
from tests.study.planted import CLONING, CORNERS, cloning, evidence, read

FOUR = [(32, 2), (32, 128), (2048, 2), (2048, 128)]
SIX = list(STUDY_TASKS)


@pytest.mark.parametrize(
    ("key", "trend"),
    [
        ("co_block_stack", {"CO": 0.8}),
        ("stiffness_hurts", {"CO": 0.8, "CU": 0.7}),
        ("damping_helps", {"CO": 0.8, "SO": 0.8}),
        ("compliant_once_overdamped", {"CO": 0.8}),
        ("overdamped_once_compliant", {"CO": 0.8}),
    ],
)
def test_regions_of_cloning(key, trend):
    path = "block_stack__nominal__cells"
    assert verdict(key, **{path: cloning(**trend)}) is YES
    assert verdict(key, **{path: cloning()}) is NO
    assert verdict(key, **{path: cloning(FOUR, **trend)}) is OPEN
    assert verdict(key) is NOT_RUN


def test_slopes_over_all_tasks_need_each_of_them_and_both_signs():
    def tasks(names=SIX, cells=None, **trend):
        table = cloning(**trend) if cells is None else cloning(cells, **trend)
        return {f"{name}__nominal__cells": table for name in names}

    both, damping, stiffness = {"CO": 0.8, "SO": 0.6, "CU": 0.5}, {"CO": 0.8, "SO": 0.8}, {}
    assert verdict("pooled_slopes", **tasks(**both)) is YES
    assert verdict("pooled_slopes", **tasks(**damping)) is NO
    assert verdict("pooled_slopes", **tasks(**stiffness)) is NO
    assert verdict("pooled_slopes", **tasks(SIX[1:], **both)) is NOT_RUN
    assert verdict("pooled_slopes", **tasks(cells=FOUR, **both)) is OPEN
    # a cell that one task lacks is left out
    lacking = tasks(**both) | tasks(SIX[:1], cells=FOUR, **both)
    assert CLAIMS["pooled_slopes"].finding(evidence(**lacking)).n == 4


def end_to_end(collections=3, seeds=3, **by_region):
    """Policies of an operator's demonstrations at the corners, a row each."""
    one = cloning(FOUR, **by_region)
    rows = [
        one.assign(success=one.success + 0.01 * i + 0.001 * seed, collection=i, seed=seed)
        for i in range(collections)
        for seed in range(seeds)
    ]
    return {"block_stack_teleoperated__operator__cells": pd.concat(rows)}


def test_end_to_end_asks_whether_every_other_corner_is_worse():
    assert verdict("end_to_end", **end_to_end(CO=0.8)) is YES
    assert verdict("end_to_end", **end_to_end(CO=0.8, SO=0.8)) is NO
    assert verdict("end_to_end", **end_to_end(CO=0.5, CU=0.9)) is NO
    # of two collections a corner, the least p is a sixth
    assert verdict("end_to_end", **end_to_end(collections=2, CO=0.8)) is OPEN
    found = CLAIMS["end_to_end"].finding(evidence(**end_to_end(CO=0.8)))
    assert found.n == 12
    assert found.ours.startswith("CO 8")
    assert verdict("end_to_end", block_stack__nominal__cells=cloning(CO=0.8)) is NOT_RUN
    few = cloning([(32, 2), (2048, 128)])
    assert verdict("end_to_end", block_stack_teleoperated__operator__cells=few) is NOT_RUN


def test_trainings_on_one_collection_are_one_unit():
    many = end_to_end(collections=1, seeds=20, CO=0.8)
    assert verdict("end_to_end", **many) is OPEN
    assert CLAIMS["end_to_end"].finding(evidence(**many)).n == 4
    # so they are where the table does not say which collection it is
    ((path, table),) = many.items()
    assert verdict("end_to_end", **{path: table.drop(columns="collection")}) is OPEN


def test_the_project_s_own_first_grid_is_told_as_it_is():
    """Region means of the first 16 cells, CO 41, SO 51, CU 40, SU 8: compliance does not help."""
    table = cloning(CO=0.41, SO=0.51, CU=0.40, SU=0.08)
    assert verdict("compliant_once_overdamped", block_stack__nominal__cells=table) is NO
    assert verdict("damping_helps", block_stack__nominal__cells=table) is YES


@pytest.mark.parametrize(
    ("key", "folder"),
    [
        ("ablation_chunk", "block_stack__chunk_1"),
        ("ablation_history", "block_stack__history_1"),
        ("ablation_10_hz", "block_stack__rate_10_hz"),
        ("ablation_joint_delta", "block_stack__joint_deltas"),
        ("another_robot", "block_stack_ur5e__nominal"),
        ("ablation_no_gravity_compensation", "block_stack_no_gravity_compensation__nominal"),
    ],
)
def test_a_variant_or_another_task_has_a_row_of_its_own(key, folder):
    tables = {f"{folder}__cells": cloning(CO=0.8)}
    assert verdict(key, **tables) is YES
    assert verdict("co_block_stack", **tables) is NOT_RUN


def test_policies_of_which_none_works_tell_nothing_of_gains():
    none = cloning(CO=0.0, SO=0.02, CU=0.01, SU=0.0)
    none["success"] = none.success.clip(upper=0.04)
    assert verdict("ablation_history", block_stack__history_1__cells=none) is OPEN
    some = none.assign(success=none.success.where(none.kd < 100, 0.15))
    assert verdict("ablation_history", block_stack__history_1__cells=some) is not OPEN


def test_the_joint_row_of_classes_asks_for_all_of_them():
    def classes(*better, **others):
        tables = {f"block_stack__{name}__cells": cloning(CO=0.8) for name in better}
        return tables | {f"block_stack__{name}__cells": table for name, table in others.items()}

    *most, last = ablations.CLASSES
    assert verdict("ablation_classes", **classes(*most, last)) is YES
    # one that was not run, or is too small to tell, leaves it open
    assert verdict("ablation_classes", **classes(*most)) is OPEN
    assert verdict("ablation_classes", **classes(*most, **{last: cloning(FOUR, CO=0.8)})) is OPEN
    # one without the preference decides, whatever was not run
    assert verdict("ablation_classes", **classes(*most, **{last: cloning()})) is NO
    assert verdict("ablation_classes", **classes(last, nominal=cloning())) is NO
    assert verdict("ablation_classes", **classes("nominal")) is NOT_RUN

    found = CLAIMS["ablation_classes"].finding(evidence(**classes(*most, **{last: cloning()})))
    assert found.ours == f"in {len(most)} of {len(most) + 1} classes"
    assert found.n == len(CLONING)
    assert found.p > 0.05


def test_of_pictures_the_cells_tell_and_no_number_of_seeds_on_five_of_them():
    few = [(32, 1), (2048, 1), (256, 8), (32, 128), (2048, 128)]

    def images(cells, seeds):
        tables = [cloning(cells, CO=0.8).assign(seed=seed) for seed in range(seeds)]
        return {"block_stack__images__cells": pd.concat(tables, ignore_index=True)}

    assert verdict("ablation_images", **images(few, 20)) is OPEN
    assert verdict("ablation_images", **images(CLONING, 1)) is YES


def test_data_that_agree_with_the_study_and_with_nothing_cannot_tell():
    """A rise of the study's size that cells scatter as much around is neither."""
    table = cloning()
    table["success"] = 0.3 + 0.25 * np.cos(np.arange(16) * 2.0)
    table["validation_mse_rad2"] = 1.0
    path = "block_stack__nominal__cells"
    assert verdict("compliant_once_overdamped", **{path: table}) is OPEN
    # the same mean without the scatter excludes it
    assert verdict("compliant_once_overdamped", **{path: cloning()}) is NO


def _loss(sign):
    """Compliant gains are harder to fit, or easier."""
    return lambda table: 1e-3 * (table.kp.astype(float) / table.kd) ** (-sign)


def test_losses():
    path = "block_stack__nominal__cells"
    harder, easier = (cloning(loss=_loss(sign)) for sign in (1, -1))
    for key in ("compliant_loss_higher", "loss_falls_with_attenuation"):
        assert verdict(key, **{path: harder}) is YES
        assert verdict(key, **{path: easier}) is NO
        assert verdict(key, **{path: cloning()}) is NOT_RUN


def test_data_sizes():
    def tables(slope, cells=CLONING):
        variants = {"demonstrations_25": 25, "nominal": 100, "demonstrations_400": 400}
        return {
            f"block_stack__{variant}__cells": cloning(
                cells, CO=0.2 + slope * np.log2(n / 25), SO=0.2, CU=0.2, SU=0.2
            ).assign(demonstrations=n)
            for variant, n in variants.items()
        }

    assert verdict("scaling", **tables(0.1)) is YES
    assert verdict("scaling", **tables(0.0)) is NO
    assert verdict("scaling", **tables(0.1, FOUR)) is OPEN
    # another study's nominal, trained better, is no larger number of demonstrations
    better = {"block_stack__nominal__cells": cloning(CO=0.9).assign(demonstrations=100)}
    both = Evidence([*read("main", better), *read("variants", tables(0.0))])
    assert CLAIMS["scaling"].finding(both).verdict is NO
    two = {name: table for name, table in tables(0.1).items() if "25" not in name}
    assert verdict("scaling", **two) is NOT_RUN


def _replays(fast=1.0, slow=0.5, mse=1e-5):
    rows = [
        (kp, kd, i < 100 * (slow if decimation > 25 else fast), mse, "sample", decimation)
        for kp, kd in CORNERS
        for decimation in (1, 25, 50)
        for i in range(100)
    ]
    columns = ["kp", "kd", "success", "mse_q_rad2", "hold", "decimation"]
    return pd.DataFrame(rows, columns=columns)


def test_retargeting():
    name = "block_stack__fidelity__kp16_kd2"
    assert verdict("retargeting_success", **{name: _replays()}) is YES
    assert verdict("retargeting_success", **{name: _replays(fast=0.88)}) is OPEN
    assert verdict("retargeting_success", **{name: _replays(fast=0.5)}) is NO
    assert verdict("retargeting_error", **{name: _replays()}) is YES
    assert verdict("retargeting_error", **{name: _replays(mse=2e-3)}) is NO
    # 2⁻⁴: four corners cannot tell
    assert verdict("retargeting_degrades", **{name: _replays()}) is OPEN
