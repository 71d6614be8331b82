import pytest
import torch
from safetensors.torch import save_file

from t2l.errors import ArtefactError
from t2l.policies import checkpoint
from t2l.policies.chunk_cvae import Architecture, ChunkCVAE


@pytest.fixture
def policy():
    torch.manual_seed(0)
    architecture = Architecture(
        observation_size=5, action_size=3, history=4, chunk=2, latent=2, hidden=(16, 16)
    )
    policy = ChunkCVAE(architecture)
    policy.normalise_by(torch.randn(50, 5) * 3 + 1, torch.randn(50, 3) * 0.1 - 2)
    return policy.eval()


def test_a_policy_survives_the_disk(policy, tmp_path):
    checkpoint.save(policy, tmp_path / "policy.safetensors")
    loaded = checkpoint.load(tmp_path / "policy.safetensors")
    history = torch.randn(7, 4, 5)
    torch.testing.assert_close(loaded(history), policy(history), rtol=0, atol=0)
    assert loaded.architecture == policy.architecture


def test_a_policy_acts_in_physical_units(policy):
    assert policy(torch.randn(6, 4, 5)).shape == (6, 2, 3)
    # near the mean action, within a few scales of it
    assert (policy(torch.randn(6, 4, 5)) + 2).abs().max() < 1


def test_an_element_that_never_changes_is_not_divided_by_zero(policy):
    policy.normalise_by(torch.ones(50, 5), torch.ones(50, 3))
    assert torch.isfinite(policy(torch.ones(1, 4, 5))).all()


def test_damaged_files_are_named(policy, tmp_path):
    path = tmp_path / "policy.safetensors"
    with pytest.raises(ArtefactError, match="no such file"):
        checkpoint.load(path)
    checkpoint.save(policy, path)
    path.write_bytes(path.read_bytes()[:-50])
    with pytest.raises(ArtefactError, match=r"policy.safetensors: cannot be read"):
        checkpoint.load(path)
    save_file({"x": torch.ones(2)}, path)
    with pytest.raises(ArtefactError, match="holds no t2l policy"):
        checkpoint.load(path)
