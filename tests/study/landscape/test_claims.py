"""Planted tables come out each way: a trend is found, so is its absence, few cells cannot tell."""

import pandas as pd
import pytest

from t2l.study.landscape.again import no_curve
from tests.study.judged import CLAIMS, NO, NOT_RUN, OPEN, YES, verdict
from tests.study.planted import CORNERS, evidence, frame


def _trials(counts, n=50):
    rows = [
        (kp, kd, "complete", 0.99 if i < count else 0.1)
        for (kp, kd), count in zip(CORNERS, counts, strict=True)
        for i in range(n)
    ]
    return pd.DataFrame(rows, columns=["kp", "kd", "state", "success"])


def test_searches_at_the_corners():
    name = "sim_to_real__{}__kp16_kd2__trials"
    study, even, one = _trials([8, 32, 4, 10]), _trials([20, 20, 20, 20]), _trials([1, 0, 1, 1], 1)
    joint, tool = name.format("joint_reach"), name.format("end_effector_reach")
    assert verdict("landscape", **{joint: study}) is YES
    assert verdict("landscape", **{joint: even}) is NO
    assert verdict("landscape", **{joint: one}) is OPEN
    other = _trials([32, 8, 4, 10])
    assert verdict("no_easier_regime", **{joint: study, tool: other}) is YES
    assert verdict("no_easier_regime", **{joint: study, tool: study}) is OPEN
    assert verdict("no_easier_regime", **{joint: study}) is OPEN
    assert verdict("no_easier_regime") is NOT_RUN


def test_solutions_exist():
    def policies(shares, cells=CORNERS):
        table = frame(cells, "transfer", success_sim_100=shares)
        return {"sim_to_real__joint_reach__cells": table}

    assert verdict("existence_joint_reach", **policies([1.0, 0.99, 1.0, 1.0])) is YES
    assert verdict("existence_joint_reach", **policies([0.78, 1.0, 0.95, 0.98])) is NO
    three = policies([1.0, 1.0, 1.0], CORNERS[:3])
    assert verdict("existence_joint_reach", **three) is NOT_RUN
    # of several policies of a corner none is picked
    one, other = policies([1.0, 1.0, 1.0, 1.0]), policies([1.0, 1.0, 0.5, 1.0])
    both = {path: pd.concat([one[path], other[path]]) for path in one}
    assert verdict("existence_joint_reach", **both) is NO


@pytest.mark.parametrize(
    ("key", "task", "cells"),
    [
        ("existence_end_effector_reach", "end_effector_reach_by_distance", CORNERS),
        ("existence_lift", "lift_cube", CORNERS),
        ("existence_g1", "track_velocity", [(0.25, 0.25), (0.25, 4), (4, 0.25), (4, 4)]),
        (
            "existence_allegro",
            "in_hand_cube_isaaclab",
            [(0.25, 0.25), (0.25, 4), (4, 0.25), (4, 4)],
        ),
    ],
)
def test_policies_that_are_found_exist_and_those_that_are_not_show_nothing(key, task, cells):
    def learned(successes, cells=cells, seed=1):
        kp, kd = zip(*cells, strict=True)
        columns = {"task": task, "kp": kp, "kd": kd, "seed": seed, "episodes": 500}
        other = pd.DataFrame({**columns, "task": "another", "successes": 0})
        return pd.concat([other, pd.DataFrame({**columns, "successes": successes})])

    def judged(*tables):
        return verdict(key, learning__policies=pd.concat(tables))

    assert judged(learned([500, 495, 500, 500])) is YES
    assert judged(learned([500, 500, 0, 500])) is OPEN
    assert judged(learned([500, 500, 500], cells[:3])) is NOT_RUN
    # all policies of a corner count together
    assert judged(learned([500] * 4), learned([500, 490, 500, 500], seed=2)) is YES
    assert judged(learned([500] * 4), learned([500, 480, 500, 500], seed=2)) is OPEN
    told = CLAIMS[key].finding(evidence(learning__policies=learned([500, 500, 0, 500]))).ours
    assert "0.0% of 500" in told
    assert "shows no absence" in told


def test_what_chose_a_policy_is_no_evidence_that_it_exists():
    """The best of fifty trials, on the episodes by which they were ranked."""
    trials = {"sim_to_real__joint_reach__kp16_kd2__trials": _trials([1, 1, 1, 1])}
    assert verdict("existence_joint_reach", **trials) is NOT_RUN
    # each run is trained by chance: the best of six scales is no better from other seeds
    lucky = again([5000] * 4, never=(2, 3, 4))
    assert verdict("existence_joint_reach", **lucky) is NO
    assert verdict("existence_joint_reach", **again([5000] * 4)) is YES
    assert verdict("existence_joint_reach", **again([5000] * 4, never=(0,))) is YES
    assert verdict("existence_joint_reach", **again([5000] * 4, seeds=1)) is NOT_RUN


def test_few_that_take_long_are_seen():
    """At one corner one configuration in six takes eight times as long: not in the mean."""
    even = again([3000] * 4, configurations=24)
    late = again([3000, 3000, 24_000, 3000], configurations=4)
    mixed = even | late
    assert verdict("sample_efficiency", **even) is YES
    found = CLAIMS["sample_efficiency"].finding(evidence(**mixed))
    assert found.verdict is not YES
    assert "one in ten takes longer than" in found.ours


def test_training_takes_as_long():
    def curves(factors, seeds=5):
        rows = [
            (kp, kd, seed, step, 1.0 if step >= factor * (1000 + 10 * seed) else 0.0)
            for (kp, kd), factor in zip(CORNERS, factors, strict=True)
            for seed in range(seeds)
            for step in range(100, 20_000, 100)
        ]
        columns = ["kp", "kd", "seed", "steps", "success"]
        return {
            "sim_to_real__joint_reach__kp16_kd2__seed1__training": pd.DataFrame(
                rows, columns=columns
            )
        }

    assert verdict("sample_efficiency", **curves([1, 1.2, 1.1, 1])) is YES
    assert verdict("sample_efficiency", **curves([1, 1, 8, 1])) is NO
    assert verdict("sample_efficiency", **curves([1, 1, 1, 1], seeds=1)) is OPEN


def again(steps, deviation=(1, 1, 1, 1), configurations=6, seeds=5, never=()):
    """Training again at each of `CORNERS`, by file: steps to success, spread of reward by seed.

    Args:
        never: seeds that do not succeed.
    """
    columns = ["configuration", "seed", "update", "steps", "reward", "success", "kp", "kd"]
    tables = {}
    for (kp, kd), needed, spread in zip(CORNERS, steps, deviation, strict=True):
        for c in range(configurations):
            for seed in range(seeds):
                at = needed * (1 + 0.05 * c) * (1 + 0.02 * seed)
                level = 0.5 + 0.2 * c + 0.01 * spread * (1 + 0.05 * c) * (-1) ** seed
                rows = [
                    (7 * c, seed, update, 1000 * update, level + 0.1 * update,
                     float(1000 * update >= at and seed not in never), kp, kd)
                    for update in range(1, 41)
                ]  # fmt: skip
                path = f"sim_to_real__joint_reach__kp{kp}_kd{kd}__again__{c + 1}_seed{seed}"
                tables[path] = pd.DataFrame(rows, columns=columns)
    return tables


def test_what_passed_is_trained_again_and_takes_as_long():
    even, slow = again([5000, 6000, 5500, 5000]), again([3000, 3000, 12_000, 3000])
    assert verdict("sample_efficiency", **even) is YES
    assert verdict("sample_efficiency", **slow) is NO
    assert verdict("sample_efficiency", **again([5000, 5000, 10_000, 5000])) is OPEN
    # five seeds of two configurations are two units
    assert verdict("sample_efficiency", **again([5000] * 4, configurations=2)) is OPEN
    found = CLAIMS["sample_efficiency"].finding(evidence(**even))
    assert found.n == 24
    assert found.ours.startswith("CO 0.007")
    assert f" million steps: factor {found.value:.2f}; one in ten" in found.ours
    # a run that never succeeds counts with all the steps it had: two of five, eight times as long
    lost = again([5000] * 4)
    lost |= {p: t for p, t in again([5000] * 4, never=(0, 1)).items() if "kp512_kd24" in p}
    steps = CLAIMS["sample_efficiency"].finding(evidence(**lost)).value
    assert steps == pytest.approx((40 / 5.8) ** 0.4, rel=0.1)
    # the training of the policy that was chosen is then not looked at
    chosen = {"sim_to_real__joint_reach__kp16_kd2__seed1__training": next(iter(slow.values()))}
    assert verdict("sample_efficiency", **chosen, **even) is YES
    # a corner where nothing passed
    three = {path: table for path, table in even.items() if "kp512_kd24" not in path}
    assert verdict("sample_efficiency", **three) is NOT_RUN
    # as they are written where fewer trials passed than are trained again
    empty = {"sim_to_real__joint_reach__kp512_kd24__again__9_seed1": no_curve()}
    assert verdict("sample_efficiency", **three, **empty) is NOT_RUN
    assert verdict("sample_efficiency", **even, **empty) is YES


def test_training_is_as_stable():
    same = [5000] * 4
    assert verdict("training_stability", **again(same, [1, 1.2, 1.1, 1])) is YES
    assert verdict("training_stability", **again(same, [1, 1, 4, 1])) is NO
    assert verdict("training_stability", **again(same, [1, 1, 2, 1])) is OPEN
    assert verdict("training_stability", **again(same, configurations=2)) is OPEN
    assert verdict("training_stability", **again(same, seeds=1)) is NOT_RUN
    # of configurations that differ in reward, each is compared with itself
    found = CLAIMS["training_stability"].finding(evidence(**again(same)))
    assert found.n == 24
    assert found.value == pytest.approx(1)
    assert found.ours == "CO 0.0123, CU 0.0123, SO 0.0123, SU 0.0123: factor 1.00"
