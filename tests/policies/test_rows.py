from dataclasses import replace

import numpy as np
import pytest
import torch

from t2l.policies import POLICIES, TrainingSet
from t2l.policies.rows import Rows
from t2l.policies.validation import split
from t2l.policies.windows import windows
from tests.policies.made import CHUNK_POLICIES, episodes, settings

CPU = torch.device("cpu")


def seeds_of_a_cell():
    """What three policies are trained on: the same episodes, others of them held out."""
    shown = episodes()
    return [TrainingSet(*split(shown, 0.2, seed), seed) for seed in (1, 2, 3)]


def test_windows_are_those_of_each_policy_by_itself():
    few, sets = settings(history=3, chunk=4), seeds_of_a_cell()
    data = Rows([e for s in sets for e in (*s.validation, *s.training)], few, CPU)
    index = []
    for one in sets:
        observation, action, past, future = windows(one.training, few.history, few.chunk)
        rows = data.of(one.training)
        history, chunk = data[rows]
        np.testing.assert_array_equal(data.observation[rows], observation)
        np.testing.assert_array_equal(history, observation[past])
        np.testing.assert_array_equal(chunk, action[future])
        index.append(rows)
    together = data[torch.stack(index)]
    for i, rows in enumerate(index):
        for found, alone in zip(together, data[rows], strict=True):
            assert torch.equal(found[i], alone)


def test_an_episode_is_stored_once_however_many_learn_from_it():
    sets = seeds_of_a_cell()
    data = Rows([e for s in sets for e in (*s.training, *s.validation)], settings(), CPU)
    steps = sum(len(e.action) for e in (*sets[0].training, *sets[0].validation))
    assert len(data.observation) == len(data.action) == steps


@pytest.mark.parametrize("kind", CHUNK_POLICIES)
def test_sharing_them_changes_no_bit_of_a_policy(kind):
    few, sets = settings(kind, epochs=3, observation_noise=0.1), seeds_of_a_cell()
    own = [
        TrainingSet([replace(e) for e in s.training], [replace(e) for e in s.validation], s.seed)
        for s in sets
    ]
    shared, copied = (POLICIES.find(kind).fit_side_by_side(each, few) for each in (sets, own))
    for (policy, losses), (other, its_losses) in zip(shared, copied, strict=True):
        assert losses.equals(its_losses)
        for name, values in policy.tensors().items():
            np.testing.assert_array_equal(values, other.tensors()[name])
