"""A policy of the user's, in a file outside the package, from its training to its rollouts."""

import numpy as np
import pytest

from t2l.config import effective
from t2l.errors import ArtefactError
from t2l.policies import POLICIES, checkpoint
from t2l.registry import load_extensions
from t2l.typed import Invalid
from tests.policies.made import episodes

FILE = '''
"""Nearest neighbour: the action of the demonstrated observation that is most alike."""

import numpy as np
import pandas as pd
from pydantic import Field

from t2l.policies import ClonedPolicy
from t2l.typed import Integer, Typed


class Settings(Typed):
    every: Integer = Field(1, ge=1, description="how many steps lie between those kept")


class NearestNeighbour(ClonedPolicy):
    name = "nearest_of_a_test"
    settings = Settings
    history = chunk = 1

    def __init__(self, seen, done):
        self.seen, self.done = seen, done
        self.observation_size, self.action_size = seen.shape[1], done.shape[1]

    @classmethod
    def fit(cls, episodes, settings, seed, threads=1):
        *rest, last = episodes
        policy = cls(*(
            np.concatenate([getattr(e, name)[:: settings.every] for e in rest])
            for name in ("observation", "action")
        ))
        error = policy.action(last.observation) - last.action
        loss = {"epoch": [1], "training_loss": [0.0], "validation_loss": [(error**2).mean()]}
        return policy, pd.DataFrame(loss)

    def act(self, history):
        apart = ((history[:, -1, None] - self.seen) ** 2).sum(axis=2)
        return self.done[apart.argmin(axis=1)][:, None]

    def tensors(self):
        return {"seen": self.seen, "done": self.done}

    def metadata(self):
        return {}

    @classmethod
    def restored(cls, tensors, metadata):
        if len(tensors["seen"]) != len(tensors["done"]):
            raise ValueError("another number of actions than of observations")
        return cls(tensors["seen"], tensors["done"])
'''
NAME = "nearest_of_a_test"


@pytest.fixture(scope="module", autouse=True)
def extension(tmp_path_factory):
    path = tmp_path_factory.mktemp("extensions") / "nearest.py"
    path.write_text(FILE)
    load_extensions([path])


def test_it_is_trained_kept_and_acts_as_any_other(tmp_path):
    section = effective({"study": "tests", "training": {"policy": NAME}})["training"]
    found = POLICIES.find(section.pop("policy"))
    policy, losses = found.fit(episodes(), found.settings(**section), seed=0)
    assert losses.validation_loss.iloc[-1] < 0.1
    checkpoint.save(policy, tmp_path / "policy.safetensors")
    loaded = checkpoint.load(tmp_path / "policy.safetensors")
    seen = episodes()[0]
    np.testing.assert_array_equal(loaded.act(seen.observation[:, None])[:, 0], seen.action)


def test_its_settings_are_checked_as_those_of_the_library():
    with pytest.raises(Invalid, match=r"training.every: found 0; allowed: a number from 1 up"):
        effective({"study": "tests", "training": {"policy": NAME, "every": 0}})
    with pytest.raises(Invalid, match=r"training.epochs: found an unknown key.*policy, every"):
        effective({"study": "tests", "training": {"policy": NAME, "epochs": 3}})


@pytest.mark.parametrize("name", ["chunk_cvea", "gaussian_mlp"])
def test_a_policy_that_cannot_be_trained_on_episodes_is_told(name):
    with pytest.raises(Invalid, match=f"training.policy: found '{name}'.*chunk_cvae, {NAME}"):
        effective({"study": "tests", "training": {"policy": name}})


def test_tensors_that_do_not_fit_are_told(tmp_path):
    found = POLICIES.find(NAME)
    checkpoint.save(found(np.ones((3, 2)), np.ones((4, 1))), tmp_path / "policy.safetensors")
    with pytest.raises(ArtefactError, match="another number of actions"):
        checkpoint.load(tmp_path / "policy.safetensors")
