"""Policies that see by cameras."""

import numpy as np
import pytest
import torch

from t2l.policies import POLICIES, Episode, Pictures, TrainingSet, checkpoint
from t2l.policies.chunk_cvae import ChunkCVAE
from t2l.policies.chunk_cvae_network import ChunkCVAENetwork
from t2l.policies.picture_encoder import shifted
from t2l.policies.validation import split
from tests.policies.made import CHUNK_POLICIES, fitted, settings

SIZE = 16
kinds = pytest.mark.parametrize("kind", CHUNK_POLICIES)


def pictured(count=16, length=20):
    """Only a picture tells what is to be done: it shows by a spot where to go."""
    rng = np.random.default_rng(0)
    where = rng.integers(2, SIZE - 2, (count * length, 2))
    store = np.zeros((count * length, 2, SIZE, SIZE, 3), np.uint8)
    for picture, (x, y) in zip(store, where, strict=True):
        picture[1, y - 2 : y + 2, x - 2 : x + 2] = (255, 40, 40)
    action = (where / SIZE).astype(np.float32)
    frames = np.arange(len(store)).reshape(count, length)
    seen = rng.normal(size=(count, length, 3)).astype(np.float32)
    return [
        Episode(observation, action[index], pictures=Pictures(store, index))
        for observation, index in zip(seen, frames, strict=True)
    ]


def blind(episodes):
    return [Episode(e.observation, e.action) for e in episodes]


# the two that take the numbers of pictures each in a way of its own
@pytest.mark.parametrize("kind", ["chunk_cvae", "chunk_transformer"])
def test_what_only_a_picture_tells_is_learned_from_it(kind):
    changes = {"history": 1, "chunk": 1, "epochs": 20, "learning_rate": 1e-2, "batch_size": 32}
    seeing, losses = fitted(pictured(), kind=kind, **changes)
    _, without = fitted(blind(pictured()), kind=kind, **changes)
    last = [table.validation_loss.iloc[-1] for table in (losses, without)]
    assert 4 * last[0] < last[1]
    assert seeing.sees_pictures


@kinds
def test_a_policy_that_sees_survives_the_disk_and_side_by_side(kind, tmp_path):
    episodes, few = pictured(6, 8), settings(kind, epochs=2, picture_shift_px=1)
    sets = [TrainingSet(*split(episodes, 0.2, seed), seed) for seed in (1, 2)]
    (policy, _), _ = POLICIES.find(kind).fit_side_by_side(sets, few)
    checkpoint.save(policy, tmp_path / "policy.safetensors")
    loaded = checkpoint.load(tmp_path / "policy.safetensors")
    history, pictures = np.zeros((4, 2, 3)), episodes[0].pictures.store[:4]
    chunk = loaded.act(history, pictures)
    np.testing.assert_array_equal(chunk, policy.act(history, pictures))
    alone, _ = POLICIES.find(kind).fit(sets[0].training, sets[0].validation, few, 1)
    np.testing.assert_allclose(
        POLICIES.find(kind).restored(policy.tensors(), policy.metadata()).act(history, pictures),
        alone.act(history, pictures),
        atol=1e-3,
    )


def test_a_shift_moves_each_camera_down_and_right_and_repeats_the_edge():
    picture = torch.arange(12).reshape(1, 1, 3, 4, 1).expand(2, 2, 3, 4, 3)
    offsets = torch.tensor([[[0, 0], [1, 0]], [[0, -2], [5, 5]]])
    first, second = shifted(picture, offsets)[..., 0].tolist()
    assert first[0] == [[0, 1, 2, 3], [4, 5, 6, 7], [8, 9, 10, 11]]
    assert first[1] == [[0, 1, 2, 3], [0, 1, 2, 3], [4, 5, 6, 7]]
    assert second[0] == [[2, 3, 3, 3], [6, 7, 7, 7], [10, 11, 11, 11]]
    assert second[1] == [[0, 0, 0, 0]] * 3


def network(cameras=2, **changes):
    torch.manual_seed(0)
    own = settings("chunk_cvae", **changes)
    known = {"observation_size": 3, "action_size": 2, "cameras": cameras}
    shared = set(ChunkCVAE.sizes.model_fields) & set(type(own).model_fields)
    return ChunkCVAENetwork(ChunkCVAE.sizes(**known, **own.model_dump(include=shared)), own)


def test_pictures_are_shifted_in_training_alone():
    moved, still = network(picture_shift_px=2), network()
    noise, shift, latent = moved.draws(8, torch.Generator().manual_seed(0))
    assert len(still.draws(8, torch.Generator())) == 2
    assert len(network(0, picture_shift_px=2).draws(8, torch.Generator())) == 2
    assert shift.unique().tolist() == [-2, -1, 0, 1, 2]
    pictures = torch.as_tensor(pictured(1, 8)[0].pictures.store)
    window = torch.zeros(8, 2, 3), torch.ones(8, 3, 2)
    found, _ = moved.loss(*window, noise, shift, latent, pictures=pictures)
    expected, _ = still.loss(*window, noise, latent, pictures=shifted(pictures, shift))
    assert found == expected
    assert found != still.loss(*window, noise, latent, pictures=pictures)[0]
    error = [each.prediction_error(*window, pictures=pictures) for each in (moved, still)]
    assert error[0] == error[1]


def test_pictures_that_do_not_fit_are_told():
    policy, _ = fitted(pictured(5, 8), epochs=1)
    with pytest.raises(ValueError, match="pictures of 0 cameras for a policy that sees by 2"):
        policy.act(np.zeros((1, 2, 3)))
    mixed = [*pictured(3, 8), *blind(pictured(3, 8))]
    with pytest.raises(ValueError, match="all have pictures of one store, or none"):
        fitted(mixed, epochs=1)
