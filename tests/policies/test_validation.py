import numpy as np
import pytest

from t2l.policies import Episode, Policy
from t2l.policies.validation import prediction_mse, split
from tests.policies.made import episodes


class Still(Policy):
    """Answers with zeros, two at a time."""

    history, chunk, observation_size, action_size = 1, 2, 4, 2

    def act(self, history):
        return np.zeros((len(history), 2, 2))

    def tensors(self):
        return {}

    def metadata(self):
        return {}

    @classmethod
    def restored(cls, tensors, metadata):
        return cls()


def test_the_error_is_a_mean_over_steps_and_chunk_of_each_element():
    action = np.array([[1.0, 0.0], [2.0, 0.0], [3.0, 4.0]])
    # chunks: 1 2, 2 3, 3 3 of the first; 0 0, 0 4, 4 4 of the second
    expected = [(1 + 4 + 4 + 9 + 9 + 9) / 6, (16 + 16 + 16) / 6]
    found = prediction_mse(Still(), [Episode(np.zeros((3, 4)), action)])
    np.testing.assert_allclose(found, expected)


def test_whole_episodes_are_held_out_and_at_least_one():
    training, validation = split(episodes(10), 0.2, seed=3)
    assert (len(training), len(validation)) == (8, 2)
    assert len(split(episodes(3), 0.01, seed=3)[1]) == 1
    again, _ = split(episodes(10), 0.2, seed=3)
    assert all(np.array_equal(a.action, b.action) for a, b in zip(training, again, strict=True))


def test_one_episode_cannot_be_split():
    with pytest.raises(ValueError, match="1 episodes"):
        split(episodes()[:1], 0.2, seed=1)
