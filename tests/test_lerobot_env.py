"""t2l's tasks as an environment of lerobot, found and driven by lerobot's own code."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from t2l.actions import make_control
from t2l.bc.rollout import roll_out
from t2l.demos.dataset import write_dataset
from t2l.demos.expert import attempt
from t2l.demos.replay import replay
from t2l.errors import ConfigurationError
from t2l.gains import Cell
from t2l.tasks.cameras import Cameras
from tests.conftest import ROOT

DECIMATION = 10
SEEDS = [3, 4, 5]
CAMERAS, SIZE = ["global", "wrist"], 32
CELL = {"task": str(ROOT / "config/tasks/block_stack.yaml"), "kp": 128, "kd": 8}
PREPARE = "import sys, setuptools.build_meta as s; s.prepare_metadata_for_build_wheel(sys.argv[1])"


@pytest.fixture(scope="module")
def plugin(tmp_path_factory):
    """A folder with what an installer writes of the plugin, by which lerobot finds it."""
    source, folder = tmp_path_factory.mktemp("plugin") / "source", tmp_path_factory.mktemp("site")
    shutil.copytree(ROOT / "src/lerobot_env_t2l", source)
    subprocess.run([sys.executable, "-c", PREPARE, str(folder)], cwd=source, check=True)
    return folder


@pytest.fixture(scope="module")
def config_class(plugin):
    from lerobot.envs import EnvConfig
    from lerobot.utils.import_utils import register_third_party_plugins

    sys.path.insert(0, str(plugin))
    register_third_party_plugins()
    sys.path.remove(str(plugin))
    return EnvConfig.get_choice_class("t2l")


@pytest.fixture(scope="module")
def config(config_class):
    return config_class(**CELL)


@pytest.fixture(scope="module")
def replays(task):
    """Of an expert from the starts that the seeds draw."""
    starts = np.concatenate([task.sample_starts(np.random.default_rng(s), 1) for s in SEEDS])
    demonstrations, succeeded = attempt(task, starts, np.random.default_rng(0))
    assert succeeded.all()
    control = make_control({"kind": "joint_target"}, Cell(128, 8), task.robot, task.model)
    return starts, control, replay(task, demonstrations, control, DECIMATION)


@pytest.fixture(scope="module")
def dataset(task, replays, tmp_path_factory):
    _, control, replayed = replays
    path = tmp_path_factory.mktemp("sets") / "kp128_kd8"
    write_dataset([r.episode for r in replayed], task, control.actions.names, 50, path)
    return path


@pytest.fixture(scope="module")
def seeing(config_class):
    """Of a policy that sees by cameras."""
    from lerobot_env_t2l.config import ObservationConfig

    return config_class(**CELL, observation=ObservationConfig(CAMERAS, SIZE))


@pytest.fixture(scope="module")
def pictured(task, replays, tmp_path_factory):
    """A data set with pictures of one colour: it is their shapes that matter."""
    _, control, replayed = replays
    path = tmp_path_factory.mktemp("sets") / "pictured"
    episodes = [r.episode for r in replayed]
    pictures = [np.full((len(e[1]), len(CAMERAS), SIZE, SIZE, 3), 9, np.uint8) for e in episodes]
    write_dataset(episodes, task, control.actions.names, 50, path, CAMERAS, SIZE, pictures)
    return path


@pytest.fixture
def arguments(monkeypatch):
    """Put words on the command line that lerobot reads."""
    return lambda *words: monkeypatch.setattr(sys, "argv", ["lerobot", *map(str, words)])


def flat(observation):
    """A vector environment's, with the cameras' pictures beside the rest."""
    return {k: v for k, v in observation.items() if k != "pixels"} | observation.get("pixels", {})


@pytest.mark.parametrize(
    ("shown_by", "held_by"),
    [("config", "dataset"), ("seeing", "pictured")],
    ids=["states", "pictures"],
)
def test_what_the_environment_shows_is_what_the_data_set_holds(shown_by, held_by, request):
    from lerobot.datasets.dataset_metadata import LeRobotDatasetMetadata
    from lerobot.envs.utils import env_to_policy_features
    from lerobot.utils.feature_utils import dataset_to_policy_features

    config = request.getfixturevalue(shown_by)
    held = LeRobotDatasetMetadata("t2l/block_stack", root=request.getfixturevalue(held_by))
    shown = env_to_policy_features(config)
    assert {k: (f.type, tuple(f.shape)) for k, f in shown.items()} == {
        k: (f.type, tuple(f.shape)) for k, f in dataset_to_policy_features(held.features).items()
    }
    ((environment,),) = [e.values() for e in config.create_envs(2).values()]
    observation, _ = environment.reset(seed=1)
    assert environment.observation_space.contains(observation)
    sizes = [held.features[key]["shape"] for key in held.features if "observation" in key]
    assert [seen.shape[1:] for seen in flat(observation).values()] == [*map(tuple, sizes)]
    environment.close()


def test_a_policy_sees_by_cameras_what_ours_sees(seeing, task):
    """What lerobot makes of the environment's pictures, while one of two episodes goes on."""
    from lerobot.envs.utils import preprocess_observation

    (environment,) = seeing.create_envs(2)["t2l"].values()
    before, _ = environment.reset(seed=SEEDS[:2])
    action = np.zeros(environment.action_space.shape, np.float32)
    action[1] = np.nan
    after, *_ = environment.step(action)
    starts = np.concatenate([task.sample_starts(np.random.default_rng(s), 1) for s in SEEDS[:2]])
    with Cameras(task.spec(visual=True).compile(), CAMERAS, SIZE) as cameras:
        expected = cameras.pictures(starts)
    for i, name in enumerate(CAMERAS):
        seen = preprocess_observation(before)[f"observation.images.{name}"].numpy()
        np.testing.assert_allclose(seen, expected[:, i].transpose(0, 3, 1, 2) / 255, atol=1e-6)
        assert (after["pixels"][name][0] != before["pixels"][name][0]).any()
        np.testing.assert_array_equal(after["pixels"][name][1], before["pixels"][name][1])
    environment.close()


def test_lerobot_and_behaviour_cloning_agree(config, task, replays):
    """The same actions from the same starts: the same observations and outcomes, to the last bit.

    Two episodes repeat an expert, at lengths of their own; the last one fails.
    """
    import torch
    from lerobot.scripts.lerobot_eval import rollout

    starts, control, replayed = replays
    ticks = round(task.horizon_s * 50)
    actions = np.stack(
        [r.episode[1][np.minimum(np.arange(ticks), len(r.episode[1]) - 1)] for r in replayed]
    ).astype(np.float32)
    actions[2] = actions[2, 0]

    class Scripted(torch.nn.Module):
        def reset(self):
            self.asked = 0

        def select_action(self, observation):
            self.asked += 1
            assert observation["task"] == [task.instruction] * len(SEEDS)
            return torch.from_numpy(actions[:, self.asked - 1])

    seen = []

    def act(past):
        at = len(seen)
        seen.append(past[:, -1])
        # those that run still, in their order
        return actions[running[at], at : at + 1]

    (environment,) = config.create_envs(len(SEEDS))["t2l"].values()
    processors = [*config.get_env_processors(), lambda value: value, lambda value: value]
    theirs = rollout(environment, Scripted(), *processors, SEEDS, return_observations=True)
    done = theirs["done"].numpy()
    running = np.concatenate([np.ones((1, len(SEEDS)), bool), ~done.T])
    ours = roll_out(task, act, 1, 1, control, starts, DECIMATION)

    assert ours.table.success.tolist() == [True, True, False]
    assert theirs["success"].any(dim=1).tolist() == [True, True, False]
    assert theirs["reward"].sum(dim=1).tolist() == [1, 1, 0]
    lengths = done.argmax(axis=1) + 1
    np.testing.assert_allclose(lengths[:2] / 50, ours.table.time_to_success_s[:2])
    assert lengths[2] == ticks
    keys = ("observation.state", "observation.environment_state")
    observed = np.concatenate([theirs["observation"][key].numpy() for key in keys], axis=2)
    for k, rows in enumerate(seen):
        np.testing.assert_array_equal(observed[running[k], k], rows)


def test_an_episode_that_is_over_stays_as_it_is(config):
    (environment,) = config.create_envs(2)["t2l"].values()
    observation, _ = environment.reset(seed=SEEDS[:2])
    action = np.full(environment.action_space.shape, 0.0, np.float32)
    action[1] = np.nan
    # a copy: pictures are drawn when they are taken
    first = environment.call("render")[1].copy()
    after, reward, terminated, truncated, info = environment.step(action)
    assert terminated.tolist() == [False, True]
    assert not truncated.any()
    assert not reward.any()
    assert info["final_info"]["failure"].tolist() == [None, "diverged"]
    assert not info["final_info"]["is_success"].any()
    np.testing.assert_array_equal(after["agent_pos"][1], observation["agent_pos"][1])
    again, *_, info = environment.step(np.zeros_like(action))
    assert info == {}
    np.testing.assert_array_equal(again["agent_pos"][1], observation["agent_pos"][1])
    assert (again["agent_pos"][0] != observation["agent_pos"][0]).any()
    assert first.dtype == np.uint8
    assert first.std() > 0
    np.testing.assert_array_equal(environment.call("render")[1], first)
    with pytest.raises(ConfigurationError, match=r"action: found .*\(2, 3\); allowed: \(2, 8\)"):
        environment.step(action[:, :3])
    environment.close()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"task": "blok_stack"}, "env.task: found 'blok_stack' .did you mean block_stack"),
        ({"task": "joint_reach"}, "task: found 'joint_reach'; allowed: a task that an expert can"),
        ({"kp": 0.0}, "kp: found 0.0; allowed: a number above 0"),
        ({"kd": None}, "kd: found nothing; allowed: a damping Kd"),
        ({"fps": 30}, "fps: found 30; allowed: a divisor of the simulation's 500 Hz"),
        ({"kind": "joints"}, "actions.kind: found 'joints'.*allowed: joint_target"),
        ({"kind": "joint_target", "reference": "home"}, "actions.reference: found 'home'"),
        ({"extensions": ["none.py"]}, "none.py: no such file"),
        ({"cameras": ["rist"]}, "camera: found 'rist'; allowed: overview, global"),
    ],
    ids=[
        *("unknown", "of rewards", "stiffness", "damping", "rate", "kind", "reference"),
        *("extension", "camera"),
    ],
)
def test_what_is_wrong_is_named(config_class, monkeypatch, change, message):
    from draccus.utils import DecodingError

    from lerobot_env_t2l.config import ActionsConfig, ObservationConfig

    monkeypatch.chdir(ROOT)
    actions = {key: change[key] for key in ("kind", "reference") if key in change}
    seen = {"observation": ObservationConfig(change["cameras"])} if "cameras" in change else {}
    rest = {key: value for key, value in change.items() if key not in (*actions, "cameras")}
    with pytest.raises(DecodingError, match=message):
        config_class(**CELL | rest, **seen, actions=ActionsConfig(**actions))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({}, ""),
        ({"fps": 25}, "fps: found 50; allowed: 25"),
        (
            {"kind": "joint_delta"},
            r"action\[0\]: found q_des.fr3_joint1; allowed: delta.fr3_joint1",
        ),
        ({"kind": "task_pose"}, r"action: found shape \(8,\); allowed: \(10,\)"),
    ],
    ids=["fits", "rate", "names", "shape"],
)
def test_a_data_set_that_does_not_fit_is_refused(config_class, dataset, arguments, change, message):
    from lerobot_env_t2l.config import ActionsConfig

    actions = ActionsConfig(change.pop("kind", "joint_target"))
    config = config_class(**CELL | change, actions=actions)
    arguments("--dataset.repo_id=t2l/block_stack", f"--dataset.root={dataset}")
    if not message:
        config.get_env_processors()
        return
    with pytest.raises(ConfigurationError, match=message) as error:
        config.get_env_processors()
    assert str(dataset) in str(error.value)


WRIST = "observation.images.wrist"


@pytest.mark.parametrize(
    ("shown_by", "key", "shape", "message"),
    [
        ("config", "observation.state", (24,), ""),
        ("config", "observation.state", (14,), r"state: found shape \(14,\); allowed: \(24,\)"),
        ("config", WRIST, (3, 64, 64), "found observation.images.wrist; allowed: "),
        ("seeing", WRIST, (3, SIZE, SIZE), ""),
        ("seeing", WRIST, (3, 64, 64), r"found shape \(3, 64, 64\); allowed: \(3, 32, 32\)"),
        ("seeing", "observation.environment_state", (14,), "found observation.environment_state;"),
    ],
    ids=["fits", "shape", "camera", "sees", "size", "state"],
)
def test_a_policy_that_does_not_fit_is_refused(
    request, arguments, tmp_path, shown_by, key, shape, message
):
    from lerobot.configs import FeatureType, PolicyFeature
    from lerobot.policies.act.configuration_act import ACTConfig

    config = request.getfixturevalue(shown_by)
    kinds = {"state": FeatureType.STATE, "environment_state": FeatureType.ENV}
    kind = kinds.get(key.split(".")[1], FeatureType.VISUAL)
    ACTConfig(
        input_features={key: PolicyFeature(kind, shape)},
        output_features={"action": PolicyFeature(FeatureType.ACTION, (8,))},
        device="cpu",
    ).save_pretrained(tmp_path)
    arguments(f"--policy.path={tmp_path}")
    if not message:
        config.create_envs(1)
        return
    with pytest.raises(ConfigurationError, match=message):
        config.create_envs(1)


SMALL_ACT = ["chunk_size=10", "n_action_steps=10", "dim_model=64", "dim_feedforward=128"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("held_by", "policy"),
    [
        ("dataset", ["act", *SMALL_ACT]),
        ("dataset", ["diffusion", "down_dims=[32,64]", "n_groups=8", "num_inference_steps=2"]),
        # weights from elsewhere would be asked for over the network
        ("pictured", ["act", *SMALL_ACT, "pretrained_backbone_weights=null"]),
    ],
    ids=["act", "diffusion", "pictures"],
)
def test_lerobot_trains_and_evaluates(plugin, request, tmp_path, held_by, policy):
    """By the commands of docs/lerobot.md, with a small network and few steps."""
    (kind, *settings), dataset = policy, request.getfixturevalue(held_by)
    cell = ["--env.type=t2l", "--env.task=block_stack", "--env.kp=128", "--env.kd=8"]
    if held_by == "pictured":
        cell += ["--env.observation.cameras=[global,wrist]", f"--env.observation.size_px={SIZE}"]
    train = [
        *(
            "--dataset.repo_id=t2l/block_stack",
            f"--dataset.root={dataset}",
            f"--policy.type={kind}",
        ),
        *(f"--policy.{setting}" for setting in settings),
        *("--policy.device=cpu", "--policy.push_to_hub=false", f"--output_dir={tmp_path}/trained"),
        *("--steps=4", "--batch_size=4", "--num_workers=0", "--env_eval_freq=4"),
        *cell,
        *("--env.picture_hz=0", "--eval.n_episodes=2", "--eval.batch_size=2"),
    ]
    evaluate = [
        f"--policy.path={tmp_path}/trained/checkpoints/last/pretrained_model",
        *("--policy.device=cpu", f"--output_dir={tmp_path}/evaluated"),
        *cell,
        *("--env.picture_hz=0", "--eval.n_episodes=3", "--eval.batch_size=3", "--seed=7"),
    ]
    path = os.pathsep.join([str(plugin), str(ROOT / "src"), os.environ.get("PYTHONPATH", "")])
    environment = {**os.environ, "PYTHONPATH": path, "HF_HUB_OFFLINE": "1"}
    environment["HF_HOME"] = str(tmp_path / "home")
    for command, words in (("lerobot-train", train), ("lerobot-eval", evaluate)):
        program = Path(sys.executable).with_name(command)
        done = subprocess.run(
            [program, *words], cwd=ROOT, env=environment, capture_output=True, text=True
        )
        assert done.returncode == 0, done.stderr[-3000:]
    info = json.loads((tmp_path / "evaluated/eval_info.json").read_text())
    assert info["overall"]["n_episodes"] == 3
    assert len(info["per_task"][0]["metrics"]["successes"]) == 3
    videos = [Path(video) for video in info["overall"]["video_paths"]]
    assert len(videos) == 3
    assert all(video.stat().st_size > 1000 for video in videos)
