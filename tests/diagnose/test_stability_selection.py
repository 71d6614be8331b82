import numpy as np
import pytest

from t2l.diagnose.settings import SELECTIONS
from t2l.diagnose.stability_selection import Dictionary, Group, shares

NBLOCK, EACH = 20, 50
BLOCK = np.repeat(np.arange(NBLOCK), EACH)
TIME = np.arange(NBLOCK * EACH) / EACH


def wave(hz):
    return np.sin(10 * np.pi * hz * TIME + hz)  # several periods in each block


GROUPS = [
    Group("one", wave(0.3)[:, None], 1),
    Group("two", wave(0.7)[:, None], 1),
    Group("three", np.stack([wave(1.1), wave(1.3)], axis=1), 2),
    Group("idle", wave(3.7)[:, None], 1),
]


def noise(size, seed=0):
    return size * np.random.default_rng(seed).normal(size=len(TIME))


def dictionary(target, groups=GROUPS, base=None):
    base = np.zeros((len(TIME), 0)) if base is None else base
    return Dictionary(target, base, groups, BLOCK)


def test_of_few_blocks_no_share_is_told():
    short = np.arange(len(TIME)) * 4 // len(TIME)
    few = Dictionary(wave(0.3), np.zeros((len(TIME), 0)), GROUPS, short)
    selections = list(few.selections())
    assert shares(selections, ["one"]) == {"one": None}


@pytest.mark.parametrize(
    ("hidden", "found"),
    [
        (wave(0.3), ("one",)),
        (wave(0.3) + 0.7 * wave(0.7), ("one", "two")),
        (wave(0.3) + wave(0.7) + wave(1.1) - wave(1.3), ("one", "three", "two")),
        (0.0 * TIME, ()),
    ],
)
def test_what_is_hidden_is_selected_on_every_resample(hidden, found):
    selections = list(dictionary(hidden + noise(0.1)).selections())
    assert len(selections) == SELECTIONS
    assert set(selections) == {found}
    assert shares(selections, ["one", "idle"]) == {"one": float("one" in found), "idle": 0.0}


def test_a_mimic_of_two_is_taken_back_once_both_are_found():
    mimic = Group("mimic", (wave(0.3) + 0.9 * wave(0.7) + 0.5 * wave(2.9))[:, None], 1)
    selections = list(
        dictionary(wave(0.3) + wave(0.7) + noise(0.05), [*GROUPS, mimic]).selections()
    )
    assert set(selections) == {("one", "two")}


def test_of_two_that_explain_alike_the_one_with_fewer_parameters_is_chosen():
    wider = Group("wider", np.stack([wave(0.3), wave(5.1)], axis=1), 2)
    target = wave(0.3) + 0.02 * wave(5.1) + noise(0.1)
    assert set(dictionary(target, [wider, *GROUPS]).selections()) == {("one",)}


def test_what_cannot_be_told_apart_shares_the_choice():
    """Two responses that differ by less than the noise: neither is chosen always."""
    twin = Group("twin", (wave(0.3) + 0.05 * noise(1.0, 1))[:, None], 1)
    other = Group("other", (wave(0.3) + 0.05 * noise(1.0, 2))[:, None], 1)
    selections = list(dictionary(wave(0.3) + noise(0.3), [twin, other]).selections())
    told = shares(selections, ["twin", "other"])
    assert sum(told.values()) == pytest.approx(1.0)
    assert 0 < told["twin"] < 1


def test_what_the_model_so_far_explains_needs_no_effect():
    base = wave(0.3)[:, None]
    assert set(dictionary(wave(0.3) + noise(0.1), base=base).selections()) == {()}


def test_an_effect_is_not_selected_beside_one_that_contains_it():
    wider = Group("wider", np.stack([wave(0.3), wave(0.7)], axis=1), 2, frozenset({"one"}))
    one = Group("one", wave(0.3)[:, None], 1, frozenset({"wider"}))
    for chosen in dictionary(wave(0.3) + wave(0.7) + noise(0.05), [wider, one]).selections():
        assert chosen == ("wider",)


@pytest.mark.parametrize("seed", range(10))
def test_groups_that_overlap_are_not_added_and_dropped_for_ever(seed):
    rng = np.random.default_rng(seed)
    block = np.repeat(np.arange(7), 25)
    shared = rng.normal(size=(len(block), 3))
    groups = [
        Group(f"group {i}", shared @ rng.normal(size=(3, 2)) + rng.normal(size=(len(block), 2)), i)
        for i in range(12)
    ]
    target = shared @ rng.normal(size=3) + rng.normal(size=len(block))
    few = Dictionary(target, np.zeros((len(block), 0)), groups, block)
    assert 40 < len(list(few.selections())) <= SELECTIONS
