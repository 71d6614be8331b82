"""lerobot's own policies: small ones, trained once for the module, as importing lerobot is slow."""

import copy
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
import torch
from safetensors.numpy import save_file

from t2l.config import effective, relations
from t2l.config.models import Configuration
from t2l.config.training import configuration_model
from t2l.errors import ArtefactError
from t2l.policies import POLICIES, Episode, checkpoint
from t2l.policies.lerobot_policy import side_by_side
from t2l.policies.validation import prediction_mse
from t2l.typed import Invalid, check
from tests.policies.made import header

SMALL = {
    "lerobot_act": {
        "history": 2, "chunk_size": 3, "dim_model": 16, "n_heads": 2, "dim_feedforward": 32,
        "latent_dim": 2, "n_encoder_layers": 1, "n_vae_encoder_layers": 1, "dropout": 0,
        "optimizer_lr": 1e-2,
    },
    "lerobot_diffusion": {
        "n_obs_steps": 2, "horizon": 4, "n_action_steps": 3, "down_dims": [64], "kernel_size": 3,
        "num_train_timesteps": 20, "num_inference_steps": 5, "scheduler_warmup_steps": 20,
        "optimizer_lr": 3e-3,
    },
}  # fmt: skip
kinds = pytest.mark.parametrize("kind", SMALL)


def shown():
    """Five demonstrations, told apart by what is seen; its first two numbers are the robot's."""
    draw = np.random.default_rng(0).normal
    return [
        Episode(
            (seen + 0.1 * draw(size=(20, 4))).astype(np.float32),
            np.broadcast_to(5 + 3 * done, (20, 2)).astype(np.float32),
            robot_size=2,
        )
        for seen, done in zip(draw(size=(5, 4)), draw(size=(5, 2)), strict=True)
    ]


def fitted(kind, seed=1, given=None, **changes):
    found = POLICIES.find(kind)
    settings = found.settings(**{"batch_size": 50, "epochs": 100} | SMALL[kind] | changes)
    given = given or shown()
    return found.fit(given, given[:1], settings, seed)


def test_observations_side_by_side_keep_the_robot_first():
    seen = np.arange(12).reshape(2, 2, 3)
    assert side_by_side(seen, robot_size=2).tolist() == [[0, 1, 3, 4, 2, 5], [6, 7, 9, 10, 8, 11]]


@pytest.fixture(scope="module")
def trained():
    """A policy of each kind with its losses."""
    return {kind: fitted(kind) for kind in SMALL}


def history_of(policy, rows=7):
    shape = rows, policy.history, policy.observation_size
    return np.random.default_rng(0).normal(size=shape).astype(np.float32)


@kinds
def test_few_demonstrations_are_learned_by_heart(kind, trained):
    policy, losses = trained[kind]
    assert losses.training_loss.iloc[-1] < losses.training_loss.iloc[0] / 3
    variance = np.concatenate([e.action for e in shown()]).var(axis=0)
    # 1 is the error of always acting the mean action, 2 of acting any that was shown
    assert (prediction_mse(policy, shown()) / variance).mean() < 0.2
    assert losses.validation_loss.iloc[-1] < 0.2
    assert policy.act(history_of(policy)).shape == (7, policy.chunk, 2)


@kinds
def test_a_policy_survives_the_disk(kind, trained, tmp_path):
    policy, path = trained[kind][0], tmp_path / "policy.safetensors"
    checkpoint.save(policy, path)
    loaded, history = checkpoint.load(path), history_of(policy)
    # a policy anew: one that draws has drawn for other tests
    same = type(policy)(policy.network, policy._features, policy._keys)
    np.testing.assert_array_equal(loaded.act(history), same.act(history))
    checkpoint.save(loaded, tmp_path / "again.safetensors")
    assert (tmp_path / "again.safetensors").read_bytes() == path.read_bytes()


@kinds
def test_lerobot_acts_alike_by_what_is_saved_for_it(kind, trained, tmp_path):
    from lerobot.policies.factory import get_policy_class, make_pre_post_processors
    from lerobot.utils.constants import OBS_ENV_STATE, OBS_STATE

    ours = checkpoint_of(trained[kind][0], tmp_path)
    ours.save_pretrained(tmp_path / "pretrained")
    theirs = get_policy_class(ours.kind).from_pretrained(tmp_path / "pretrained")
    before, after = make_pre_post_processors(theirs.config, str(tmp_path / "pretrained"))
    # what it sees first, lerobot takes for all that was before
    history = np.repeat(history_of(ours)[:, :1], ours.history, axis=1)
    robot, environment = torch.from_numpy(history[:, 0]).split(2, dim=1)
    if kind == "lerobot_act":
        robot, environment = (part.repeat(1, ours.history) for part in (robot, environment))
    torch.manual_seed(1)
    action = after(theirs.select_action(before({OBS_STATE: robot, OBS_ENV_STATE: environment})))
    np.testing.assert_allclose(ours.act(history)[:, 0], action, atol=1e-6)


def checkpoint_of(policy, folder):
    """The policy as it is read again."""
    checkpoint.save(policy, folder / "policy.safetensors")
    return checkpoint.load(folder / "policy.safetensors")


@kinds
def test_the_same_seed_gives_the_same_policy_and_nothing_else_changes(kind):
    torch.manual_seed(5)
    expected = torch.rand(3)
    torch.manual_seed(5)
    (one, losses), (same, _), (other, _) = (fitted(kind, seed, epochs=2) for seed in (1, 1, 2))
    history = history_of(one)
    # epochs have asked as often
    np.testing.assert_array_equal(one.act(history), same.act(history))
    assert not np.array_equal(one.act(history), other.act(history))
    assert losses.epoch.tolist() == [1, 2]
    assert torch.equal(torch.rand(3), expected)


@kinds
def test_an_element_that_never_changes_is_not_divided_by_zero(kind):
    still = [
        replace(e, observation=np.ones_like(e.observation), action=np.ones_like(e.action))
        for e in shown()
    ]
    policy, _ = fitted(kind, given=still, epochs=1)
    near = np.full((3, policy.history, 4), 1.001, np.float32)
    assert np.abs(policy.act(near)).max() < 10


@kinds
def test_files_of_no_such_policy_are_told(kind, trained, tmp_path):
    policy, path = trained[kind][0], tmp_path / "policy.safetensors"
    metadata = policy.metadata()
    for wrong in (
        {},
        metadata | {"features": metadata["features"] | {"robot": 6}},
        metadata | {"features": metadata["features"] | {"robot": 2**40}},
        metadata | {"config": {}},
        metadata | {"config": metadata["config"] | {"device": "cuda"}},
    ):
        save_file(policy.tensors(), path, header(policy.name, wrong))
        with pytest.raises(ArtefactError, match=r"policy.safetensors: makes no sense"):
            checkpoint.load(path)


@pytest.mark.parametrize(
    ("section", "message"),
    [
        ({"policy": "lerobot_act", "chunk_size": 0}, r"chunk_size: found 0; allowed: .* from 1"),
        ({"policy": "lerobot_act", "n_obs_steps": 2}, "n_obs_steps: found an unknown key"),
        ({"policy": "lerobot_act", "history": 0}, r"history: found 0; allowed: .* from 1"),
        ({"policy": "lerobot_act", "chunk": 5}, "chunk: found an unknown key .*chunk_size"),
        ({"policy": "lerobot_act", "n_heads": 3}, "a dim_model that is a multiple of n_heads"),
        ({"policy": "lerobot_diffusion", "horizon": 18}, "a horizon that is a multiple of 4"),
        ({"policy": "lerobot_diffusion", "n_action_steps": 12}, "at most horizon - n_obs_steps"),
        ({"policy": "lerobot_diffusion", "kernel_size": 4}, "an odd kernel_size"),
        ({"policy": "lerobot_diffusion", "down_dims": [20]}, r"down_dims\[0\]: found 20"),
        ({"policy": "lerobot_diffusion", "noise_scheduler_type": "DIM"}, "did you mean DDIM"),
        ({"policy": "lerobot_diffusion", "num_inference_steps": 200}, "num_train_timesteps"),
        ({"policy": "lerobot_pi0"}, r"policy: found 'lerobot_pi0' \(did you mean lerobot_act"),
    ],
)
def test_wrong_settings_are_refused_by_name(section, message):
    with pytest.raises(Invalid, match=rf"(?s)training.*{message}"):
        effective({"study": "tests", "training": section})


def problems(section, task):
    written = {"study": "tests", "training": section}
    configuration: Configuration = check(configuration_model(written), written)
    return "\n".join(map(str, relations.problems(configuration, {"block_stack": task})))


def test_more_actions_than_are_answered_are_refused(task):
    assert "rollouts" not in problems({"policy": "lerobot_diffusion"}, task)
    assert (
        "rollouts.executed_actions: found 10; allowed: at most training.n_action_steps = 8"
        in problems({"policy": "lerobot_diffusion", "n_action_steps": 8}, task)
    )
    assert "at most training.chunk_size = 5" in problems(
        {"policy": "lerobot_act", "chunk_size": 5}, task
    )


@kinds
def test_a_task_that_does_not_show_its_environment_is_refused(kind, task):
    bare = copy.copy(task)
    bare.observation_names = task.observation_names[: task.robot_observation_size]
    assert f"training.policy: found '{kind}', which needs to see the environment; block_stack" in (
        problems({"policy": kind}, bare)
    )
    assert "training.policy" not in problems({}, bare)


def test_a_package_that_is_missing_is_told_before_any_job(monkeypatch):
    monkeypatch.setattr(POLICIES.find("lerobot_act"), "packages", ("lerobot", "no_such_package"))
    with pytest.raises(
        Invalid, match=r"training.policy: .*needs no_such_package: not installed; allowed: pip"
    ):
        effective({"study": "tests", "training": {"policy": "lerobot_act"}})


@kinds
def test_settings_and_names_cost_no_lerobot(kind):
    code = (
        "import sys; from t2l.config import effective\n"
        f"effective({{'study': 'x', 'training': {{'policy': {kind!r}}}}})\n"
        "print({'torch', 'lerobot', 'diffusers'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout.strip() == "set()", done.stderr
