"""A policy of the user's, in a file outside the package, from its training to its rollouts."""

import numpy as np
import pytest

from t2l.config import effective
from t2l.errors import ArtefactError
from t2l.policies import POLICIES, checkpoint
from t2l.policies.validation import split
from t2l.typed import Invalid
from tests.policies.made import episodes

NAME = "nearest_neighbour"


def test_it_is_trained_kept_and_acts_as_any_other(tmp_path):
    section = effective({"study": "tests", "training": {"policy": NAME}})["training"]
    found = POLICIES.find(section.pop("policy"))
    parts = split(episodes(), section.pop("validation_fraction"), seed=0)
    policy, losses = found.fit(*parts, found.settings(**section), seed=0)
    assert losses.validation_loss.iloc[-1] < 0.1
    checkpoint.save(policy, tmp_path / "policy.safetensors")
    loaded = checkpoint.load(tmp_path / "policy.safetensors")
    seen = parts[0][0]
    np.testing.assert_array_equal(loaded.act(seen.observation[:, None])[:, 0], seen.action)


def test_its_settings_are_checked_as_those_of_the_library():
    with pytest.raises(Invalid, match=r"training.every: found 0; allowed: a number from 1 up"):
        effective({"study": "tests", "training": {"policy": NAME, "every": 0}})
    with pytest.raises(Invalid, match=r"training.epochs: found an unknown key.*policy, .*every"):
        effective({"study": "tests", "training": {"policy": NAME, "epochs": 3}})


@pytest.mark.parametrize("name", ["chunk_cvea", "gaussian_mlp"])
def test_a_policy_that_cannot_be_trained_on_episodes_is_told(name):
    with pytest.raises(
        Invalid, match=f"training.policy: found '{name}'.*lerobot_diffusion, {NAME}"
    ):
        effective({"study": "tests", "training": {"policy": name}})


def test_tensors_that_do_not_fit_are_told(tmp_path):
    found = POLICIES.find(NAME)
    checkpoint.save(found(np.ones((3, 2)), np.ones((4, 1))), tmp_path / "policy.safetensors")
    with pytest.raises(ArtefactError, match="another number of actions"):
        checkpoint.load(tmp_path / "policy.safetensors")
