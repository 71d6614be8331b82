from functools import partial

import numpy as np
import pytest
from safetensors.numpy import save_file

from t2l.errors import ArtefactError
from t2l.policies import POLICIES, checkpoint
from tests.policies.made import CHUNK_POLICIES, chunk_policy, gaussian_mlp, header

MADE = [*(partial(chunk_policy, kind) for kind in CHUNK_POLICIES), gaussian_mlp]


@pytest.mark.parametrize("make", MADE, ids=[*CHUNK_POLICIES, "gaussian_mlp"])
def test_a_policy_survives_the_disk(make, tmp_path):
    policy, path = make(), tmp_path / "policy.safetensors"
    checkpoint.save(policy, path)
    loaded = checkpoint.load(path)
    assert type(loaded) is POLICIES.find(policy.name)
    history = np.random.default_rng(0).normal(size=(7, policy.history, policy.observation_size))
    np.testing.assert_array_equal(loaded.act(history), policy.act(history))
    assert policy.act(history).shape == (7, policy.chunk, policy.action_size)
    np.testing.assert_array_equal(loaded.action_scale, policy.action_scale)
    assert loaded.metadata() == policy.metadata()
    # and again, by what was loaded
    checkpoint.save(loaded, tmp_path / "again.safetensors")
    assert (tmp_path / "again.safetensors").read_bytes() == path.read_bytes()


def test_damaged_files_are_named(tmp_path):
    path = tmp_path / "policy.safetensors"
    with pytest.raises(ArtefactError, match="no such file"):
        checkpoint.load(path)
    checkpoint.save(chunk_policy(), path)
    path.write_bytes(path.read_bytes()[:-50])
    with pytest.raises(ArtefactError, match=r"policy.safetensors: cannot be read"):
        checkpoint.load(path)
    save_file({"x": np.ones(2)}, path)
    with pytest.raises(ArtefactError, match="holds no t2l policy"):
        checkpoint.load(path)


@pytest.mark.parametrize("name", ["chunk_cvea", "x" * 1000, "\n"])
def test_a_policy_of_an_unknown_class_is_named_with_those_that_are_known(name, tmp_path):
    path = tmp_path / "policy.safetensors"
    save_file({"x": np.ones(2)}, path, header(name, {}))
    with pytest.raises(
        ArtefactError, match=r"policy.safetensors: .*chunk_transformer, gaussian"
    ) as error:
        checkpoint.load(path)
    assert len(str(error.value)) < 500


@pytest.mark.parametrize("make", MADE, ids=[*CHUNK_POLICIES, "gaussian_mlp"])
@pytest.mark.parametrize("metadata", ["", [], {}, None, {"history": 1}, {"x": [[]] * 10000}])
def test_metadata_of_no_policy_are_told(make, metadata, tmp_path):
    policy, path = make(), tmp_path / "policy.safetensors"
    save_file(policy.tensors(), path, header(policy.name, metadata))
    with pytest.raises(ArtefactError, match=r"policy.safetensors: makes no sense"):
        checkpoint.load(path)


@pytest.mark.parametrize(
    "content", ["", "[]", "{}", "null", '{"name": [], "metadata": {}}', "{" * 10000]
)
def test_a_header_of_no_policy_is_told(content, tmp_path):
    path = tmp_path / "policy.safetensors"
    save_file({"x": np.ones(2)}, path, {"t2l_policy": content})
    with pytest.raises(ArtefactError, match=r"policy.safetensors: makes no sense"):
        checkpoint.load(path)


@pytest.mark.parametrize("size", [-1, 0, 1.5, "4", None, True, 2**40, 10**5])
def test_sizes_that_no_network_has_are_told(size, tmp_path):
    policy, path = chunk_policy(), tmp_path / "policy.safetensors"
    metadata = policy.metadata() | {"observation_size": size}
    save_file(policy.tensors(), path, header(policy.name, metadata))
    with pytest.raises(ArtefactError, match=r"policy.safetensors: makes no sense"):
        checkpoint.load(path)
