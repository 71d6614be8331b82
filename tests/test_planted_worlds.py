"""The referee of `t2l advise`: worlds, attempts in them, and the rule."""

import numpy as np
import pandas as pd
import pytest
from benchmarks.planted import cloned, verdict
from benchmarks.planted.episode import POLICY_HZ, Attempt, attempted
from benchmarks.planted.shown import HAND, Person, demonstrations, shown
from benchmarks.planted.world import drawn

from t2l.stats.planted import losses, reliability


@pytest.fixture(scope="module")
def world():
    return drawn(54, "quadruped_leg", 0)


def test_a_world_is_drawn_again_alike(world):
    again = drawn(54, "quadruped_leg", 0)
    assert again.mjcf == world.mjcf
    assert again.hidden == world.hidden
    assert (again.via == world.via).all()
    assert len(world.cells) == 16
    assert drawn(54, "quadruped_leg", 1).hidden != world.hidden


def test_a_person_shows_what_is_asked(world):
    one = shown(world, 0)
    assert one is not None
    rows, ticks = len(one.q), len(one.observation)
    assert rows == ticks * (200 // POLICY_HZ)
    assert one.observation.shape[1] == 4 * len(world.joints) + 1
    # the flag says when the first place was passed
    assert set(one.observation[:, -1]) == {0.0, 1.0}
    # at the end they are where they were asked to be
    goal = one.observation[-1, 3 * len(world.joints) : -1]
    off = (one.q[-1] - goal) / world.reach
    assert np.sqrt(np.mean(off**2)) < 2 * world.tolerance


def test_a_hand_shakes_as_it_is_said_to(world):
    attempt = Attempt.drawn(world, world.rng(9))
    attempt.via = attempt.start
    person = Person(attempt, world.rng(8))
    shakes = np.array([person(np.zeros(0), attempt.start) - person.corrected for _ in range(4000)])
    own = (shakes - attempt.start) / world.reach
    assert np.std(own) == pytest.approx(HAND, rel=0.1)


def test_who_does_not_move_fails(world):
    attempt = Attempt.drawn(world, world.rng(7))
    gains = np.full(3, world.kp[2]), np.full(3, world.kd[2])
    trace = attempted(attempt, *gains, lambda seen, link: attempt.start, world.rng(6))
    assert not attempt.success
    assert len(trace.command) == attempt.ticks


def test_policies_are_trained_and_tried(world):
    (one,) = [demonstrations(world, 3)]
    policies = cloned.trained([0], [world], [one], policies=1, epochs=1, hidden=[8])
    assert len(policies) == 16
    count, successes = cloned._tried(cloned._Job(world, policies[0], 0, 5))
    assert (count, successes) == (cloned.HOPE, 0)


def table(world, first, then):
    """Rows of four policies: successes of 8 at first, and of 24 then where that is not None."""
    rows = [
        (world.name, kp, kd, policy, 0.1, stage, rollouts, found)
        for (kp, kd), at_first, more in zip(world.cells, first, then, strict=True)
        for policy in range(cloned.POLICIES)
        for stage, rollouts, found in ((0, 8, at_first), (1, 24, more))
        if found is not None
    ]
    return pd.DataFrame(rows, columns=list(cloned.COLUMNS))


def test_what_chose_a_policy_does_not_judge_it(world):
    first, then = [0] * 16, [None] * 16
    first[3], then[3] = 8, 12
    first[5] = 2
    found = verdict.success(table(world, first, then), world)
    assert found[3].tolist() == [0.5] * 4
    assert found[5].tolist() == [0.25] * 4
    assert found[0].max() == 0


def test_the_best_cell_is_judged_by_policies_that_did_not_choose_it():
    luck = np.array([[1.0, 0.0, 1.0, 0.0], [0.6, 0.6, 0.6, 0.6]])
    # the lucky half chooses the first cell, the other half says 0; and the other way round 0.6
    assert verdict.best(luck) == pytest.approx(0.3)


def test_rules_are_measured_against_the_best():
    rows = pd.DataFrame(
        {"half": "test", "known": "nominal", "world": ["a", "b"], "best": [0.8, 0.6],
         "advised": [0.8, 0.3], "critical": 0.5, "ratio": 0.1, "ruled_out": 2, "failed": 1,
         "best_ruled_out": [False, True]}
    )  # fmt: skip
    (found,) = verdict.verdicts(rows)
    assert (found.worlds, found.within, found.ruled_out, found.best_ruled_out) == (2, 1, 4, 1)
    assert found.lost == pytest.approx(0.15)
    lost = losses(rows, {"advised": "it"})
    assert lost.lost.tolist() == pytest.approx([0.0, 0.3])


def test_the_interval_of_a_share_is_over_worlds():
    rows = pd.DataFrame(
        {"half": "test", "known": "nominal", "world": list("abcd"), "stated": 0.6,
         "pairs": [10, 10, 10, 30], "right": [0.0, 0.5, 1.0, 0.8]}
    )  # fmt: skip
    (one,) = reliability(rows).itertuples()
    assert one.right == pytest.approx((0 + 5 + 10 + 24) / 60)
    assert one.low < 0.4
    assert one.high > 0.8
