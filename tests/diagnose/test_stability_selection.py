import numpy as np
import pytest

from t2l.diagnose.settings import SELECTIONS
from t2l.diagnose.stability_selection import Dictionary, Group

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


def selections(made):
    return [made.select(drawn) for drawn in made.resamples()]


def test_of_few_blocks_no_share_is_told():
    short = np.arange(len(TIME)) * 4 // len(TIME)
    few = Dictionary(wave(0.3), np.zeros((len(TIME), 0)), GROUPS, short)
    assert set(few.shares().values()) == {None}


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
    made = dictionary(hidden + noise(0.1))
    selected = selections(made)
    assert len(selected) == SELECTIONS
    assert set(selected) == {found}
    assert made.shares() == {group.name: float(group.name in found) for group in GROUPS}


def test_a_mimic_of_two_is_taken_back_once_both_are_found():
    mimic = Group("mimic", (wave(0.3) + 0.9 * wave(0.7) + 0.5 * wave(2.9))[:, None], 1)
    made = dictionary(wave(0.3) + wave(0.7) + noise(0.05), [*GROUPS, mimic])
    assert set(selections(made)) == {("one", "two")}


def test_of_two_that_explain_alike_the_one_with_fewer_parameters_is_chosen():
    wider = Group("wider", np.stack([wave(0.3), wave(5.1)], axis=1), 2)
    target = wave(0.3) + 0.02 * wave(5.1) + noise(0.1)
    assert set(selections(dictionary(target, [wider, *GROUPS]))) == {("one",)}


def test_what_cannot_be_told_apart_does_not_split_the_choice():
    """Of two responses that differ by less than the noise neither is selected always."""
    twins = [Group(f"twin {i}", (wave(0.3) + 0.05 * noise(1.0, i))[:, None], 1) for i in (1, 2)]
    made = dictionary(wave(0.3) + noise(0.3), [*twins, *GROUPS[1:]])
    assert set(selections(made)) == {("twin 1",), ("twin 2",)}
    told = made.shares()
    assert told["twin 1"] == told["twin 2"] == 1.0
    assert told["two"] == told["idle"] == 0.0


def test_what_the_model_so_far_explains_needs_no_effect():
    base = wave(0.3)[:, None]
    assert set(selections(dictionary(wave(0.3) + noise(0.1), base=base))) == {()}


def test_an_effect_is_not_selected_beside_one_that_contains_it():
    wider = Group("wider", np.stack([wave(0.3), wave(0.7)], axis=1), 2, frozenset({"one"}))
    one = Group("one", wave(0.3)[:, None], 1, frozenset({"wider"}))
    made = dictionary(wave(0.3) + wave(0.7) + noise(0.05), [wider, one])
    assert set(selections(made)) == {("wider",)}


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
    assert 40 < len(selections(few)) <= SELECTIONS
