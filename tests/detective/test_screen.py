"""The screen's algebra."""

import copy
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from t2l.detective.candidates import Candidate, Column, Table, _pursued, _ranked
from t2l.detective.screen import Screen, bounded
from t2l.effects.registry import builtin

FOLDS = np.arange(300)[:, None] % 3


@given(st.integers(0, 10_000), st.integers(1, 6))
def test_weights_within_bounds_are_those_of_least_squares(seed, count):
    rng = np.random.default_rng(seed)
    columns, target = rng.normal(size=(40, count)), rng.normal(size=40)
    lower, upper = -rng.uniform(0, 0.3, count), rng.uniform(1e-3, 0.3, count)
    normal, goal = (columns.T @ columns)[None], (columns.T @ target)[None]
    found = bounded(normal, goal, lower[None], upper[None])[0]
    best = lsq_linear(columns, target, (lower, upper)).x
    assert (found >= lower - 1e-9).all()
    assert (found <= upper + 1e-9).all()
    left = [np.sum((target - columns @ w) ** 2) for w in (found, best)]
    assert left[0] <= left[1] * (1 + 1e-4)


def made(rng, names, n=300):
    columns = rng.normal(size=(n, len(names))).astype(np.float32)
    candidates = [
        Candidate(builtin()[name], (0,), {("x", 0): 0.0}, (), (Column(i, "x", 0, -10, 10),))
        for i, name in enumerate(names)
    ]
    return Table(columns, candidates)


def test_the_front_holds_the_set_that_made_the_data():
    rng = np.random.default_rng(0)
    table = made(rng, list(builtin())[:12])
    residual = table.columns[:, 3] - 0.7 * table.columns[:, 8] + 0.01 * rng.normal(size=300)
    screen = Screen(table, residual, FOLDS)
    front = screen.search()
    assert [one.members for one in front if one.complexity == 4] == [(3, 8)]
    assert len(front[-1].members) == 2
    assert np.allclose(screen.weights((3, 8)), [1.0, -0.7], atol=0.01)


@pytest.mark.parametrize(("joint", "together"), [(0, False), (1, True)])
def test_what_does_the_same_on_a_joint_is_in_no_set_together(joint, together):
    rng = np.random.default_rng(0)
    table = made(rng, list(builtin())[:12])
    residual = table.columns[:, 3] - 0.7 * table.columns[:, 8]
    one, other = copy.copy(table.candidates[3].effect), table.candidates[8].effect
    one.does_too = (other.name,)
    table.candidates[3] = replace(table.candidates[3], effect=one)
    table.candidates[8] = replace(table.candidates[8], joints=(joint,))
    screen = Screen(table, residual, FOLDS)
    assert any({3, 8} <= set(scored.members) for scored in screen.search()) == together
    # nor is it offered beside what a model has
    gone = replace(table.candidates[3], removal=True)
    beside = Screen(Table(table.columns, [*table.candidates, gone]), residual, FOLDS)
    assert (8 in beside.growing(())) == together
    assert 8 in beside.growing((12,))


def test_noise_alone_has_no_front():
    rng = np.random.default_rng(1)
    table = made(rng, list(builtin())[:12])
    screen = Screen(table, rng.normal(size=300), FOLDS)
    assert [one.members for one in screen.search()] == [()]


def test_a_candidate_says_all_that_a_set_without_its_effect_needs():
    """The model has it on joint 0 already, with a number of the whole robot."""
    effect = builtin()["friction_drift"]
    own = {(p.name, 1): 1.0 for p in effect.parameters if p.per_joint}
    beside = Candidate(effect, (1,), own, (), ())
    assert beside.is_new_to({"friction_drift": {0}})
    assert not beside.is_new_to({"friction_drift": {1}})
    assert not beside.is_new_to({"cogging": {0}})
    shared = {(p.name, None): 1.0 for p in effect.parameters if not p.per_joint}
    assert Candidate(effect, (1,), own | shared, (), ()).is_new_to({})


def test_a_screen_beside_a_model_is_that_of_all_columns():
    rng = np.random.default_rng(2)
    table = made(rng, list(builtin())[:12])
    derivatives, residual = rng.normal(size=(300, 2)), rng.normal(size=300)
    limits = np.array([[-0.1, 0.2], [-1.0, 1.0]]), np.zeros((0, 2)), np.zeros(0)
    kept = [0, 3, 5, 11]
    beside = Screen(table, rng.normal(size=300), FOLDS).beside(kept, derivatives, limits, residual)
    columns = np.concatenate([table.columns, derivatives.astype(np.float32)], axis=1)
    whole = Table(columns, [table.candidates[i] for i in kept], (12, 13), *limits)
    sets = [(), (0,), (1, 3), (0, 1, 2)]
    expected = Screen(whole, residual, FOLDS).scores(sets)
    for found, one in zip(beside.scores(sets), expected, strict=True):
        assert (found.members, found.complexity) == (one.members, one.complexity)
        np.testing.assert_allclose(found.error, one.error, rtol=1e-5)


def test_settings_are_ranked_beside_what_explains_most():
    """The second response is like what is missing most, the third is what is missing beside it."""
    rng = np.random.default_rng(3)
    first, second, third = rng.normal(size=(3, 300))
    values = np.stack([first, 0.3 * first + 0.1 * second, 0.1 * third], axis=1)
    residual = first + 0.1 * third
    assert _ranked(residual, values[:, 1:]) == [0, 1]
    assert _ranked(_pursued(residual, values), values[:, 1:])[0] == 1
