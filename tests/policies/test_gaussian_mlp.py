import numpy as np
import pytest
from safetensors.numpy import save_file

from t2l.errors import ArtefactError
from t2l.policies import checkpoint
from tests.policies.made import gaussian_mlp, header


def test_one_observation_one_action_within_its_bounds():
    policy = gaussian_mlp()
    observation = np.random.default_rng(1).normal(size=(50, 5))
    action = policy.action(observation)
    assert action.shape == (50, 3)
    assert np.abs(action).max() <= 1
    np.testing.assert_array_equal(policy.act(observation[:, None])[:, 0], action)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"bias1": None}, "has no bias1"),
        ({"mean": None}, "lacks 'mean'|has no mean"),
        ({"weight3": np.ones((3, 3))}, "has no"),
        ({"weight0": None, "weight1": None}, "has no weight0|has"),
        ({"note": np.ones(1)}, "has note"),
        ({"weight1": np.ones((3, 8))}, r"weight1 has shape \(3, 8\), not \(3, 9\)"),
        ({"weight0": np.ones(5)}, "weight0 has shape"),
        ({"weight0": np.ones((9, 5, 2))}, "weight0 has shape"),
        ({"bias0": np.array(1.0)}, "bias0 has shape"),
        ({"deviation": np.ones(4)}, "deviation has shape"),
        ({"mean": np.zeros((5, 1))}, "mean has shape"),
        ({"weight1": np.ones((2, 9)), "bias1": np.ones(2)}, "bias1 has shape"),
        ({"mean": np.zeros(5, int)}, "mean holds int64"),
    ],
    ids=lambda value: "" if isinstance(value, dict) else value,
)
def test_layers_that_do_not_fit_are_told(tmp_path, change, message):
    path, policy = tmp_path / "policy.safetensors", gaussian_mlp()
    head = header(policy.name, policy.metadata())
    tensors = {k: v for k, v in (policy.tensors() | change).items() if v is not None}
    save_file(policy.tensors(), path, head)
    checkpoint.load(path)
    save_file(tensors, path, head)
    with pytest.raises(ArtefactError, match=rf"policy.safetensors: .*({message})"):
        checkpoint.load(path)


@pytest.mark.parametrize("scale", [[0.1], [0.1, 0.1, -1.0], [0.1, 0.1, None], "x", 0.1])
def test_a_scale_that_does_not_fit_is_told(tmp_path, scale):
    path, policy = tmp_path / "policy.safetensors", gaussian_mlp()
    metadata = {"action_scale": scale}
    save_file(policy.tensors(), path, header(policy.name, metadata))
    with pytest.raises(ArtefactError, match=r"policy.safetensors: makes no sense"):
        checkpoint.load(path)
