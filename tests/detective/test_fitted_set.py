"""How many numbers a fitted set has, as the samples tell them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from t2l.detective.fitted_set import FittedSet, alike
from t2l.detective.pruning import without_one
from t2l.effects.registry import builtin
from t2l.effects.term import Layout, Term

JOINTS = (0, 1, 2)
NSAMPLE = 600


def fitted(effect, u, rng, moves=1.0):
    """A set of one effect on three joints, each number of which moves samples of its own joint."""
    layout = Layout([Term(builtin()[effect], JOINTS)])
    owner = np.repeat(JOINTS, NSAMPLE // 3)
    jacobian = np.where(
        owner[:, None] == [slot.joint for slot in layout.slots],
        moves * rng.normal(size=(NSAMPLE, len(layout))),
        0.0,
    )
    residual = rng.normal(size=NSAMPLE)
    told, free = np.ones(NSAMPLE, bool), np.ones(len(layout), bool)
    return FittedSet(layout, np.array(u), residual, residual, told, jacobian, free)


@pytest.mark.parametrize(
    ("effect", "u", "numbers"),
    [
        # a lag of drives that are alike is one number, whichever each joint's own fit gave
        ("actuator_bandwidth", [3.0, 3.05, 2.95], 1),
        ("actuator_bandwidth", [3.0, 3.0, 6.0], 3),
        # an inertia is a joint's own, also where two are equal
        ("armature", [0.1, 0.1, 0.1], 3),
    ],
)
def test_what_joints_may_share_counts_once_where_it_is_alike(effect, u, numbers):
    one = fitted(effect, u, np.random.default_rng(0))
    assert one.complexity == 1 + numbers
    assert one.shares(one.layout.terms[0]) == (numbers == 1)


def test_a_shared_number_is_dropped_as_a_whole():
    rng = np.random.default_rng(0)
    shared, own = (fitted("actuator_bandwidth", u, rng) for u in ([3.0] * 3, [1.0, 3.0, 6.0]))
    assert not without_one(shared)
    assert len(without_one(own)) == 3


@given(st.lists(st.floats(-5, 5), min_size=3, max_size=3), st.floats(0, 100), st.integers(0, 99))
def test_a_tie_costs_no_more_than_it_may(u, allowed, seed):
    rng, u = np.random.default_rng(seed), np.array(u)
    jacobian = rng.normal(size=(20, 3))
    slots = Layout([Term(builtin()["actuator_bandwidth"], JOINTS)]).slots
    of = alike(slots, u, jacobian.T @ jacobian, allowed)
    # the least rise of the sum of squares when all numbers are one
    one = jacobian.sum(axis=1, keepdims=True)
    target = jacobian @ u
    rise = np.sum((target - one @ np.linalg.lstsq(one, target)[0]) ** 2)
    assert set(of) == ({0} if rise <= allowed * (1 + 1e-9) + 1e-9 else {0, 1, 2}) or np.isclose(
        rise, allowed
    )


def test_what_cancels_between_joints_that_share_it_is_no_number():
    """As where two joints move all samples alike, but each against the other."""
    layout = Layout([Term(builtin()["actuator_bandwidth"], (0, 1))])
    rng = np.random.default_rng(0)
    column, residual = rng.normal(size=NSAMPLE), 1e3 * rng.normal(size=NSAMPLE)
    # what is left of the two is next to nothing
    other = -column * (1 + 1e-5 * rng.normal(size=NSAMPLE))
    jacobian = np.stack([column, other], axis=1)
    told, free = np.ones(NSAMPLE, bool), np.ones(2, bool)
    one = FittedSet(layout, np.full(2, 3.0), residual, residual, told, jacobian, free)
    assert one.shares(one.layout.terms[0])
    assert one.complexity == 1
