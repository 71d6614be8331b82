import json
import os
import shutil
import subprocess
import sys

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import yaml

from t2l.actions import make_control
from t2l.demos.dataset import read_demonstrations, write_dataset, write_demonstrations
from t2l.demos.demonstration import Demonstration
from t2l.demos.replay import replay
from t2l.errors import ArtefactError, OutputError
from t2l.gains import Cell
from t2l.tasks import make_task
from tests.conftest import ROOT

# lerobot opens the data set from disk and trains its own policy on it
TRAIN_WITH_LEROBOT = """
import sys
import torch
from lerobot.configs import FeatureType
from lerobot.utils.feature_utils import dataset_to_policy_features
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot.policies.act.configuration_act import ACTConfig
from lerobot.policies.act.modeling_act import ACTPolicy

root, = sys.argv[1:]
torch.manual_seed(0)
dataset = LeRobotDataset(
    "t2l/block_stack", root=root, delta_timestamps={"action": [i / 50 for i in range(10)]}
)
assert dataset.fps == 50
assert "red block" in dataset[0]["task"]
features = dataset_to_policy_features(dataset.meta.features)
policy = ACTPolicy(
    ACTConfig(
        input_features={k: f for k, f in features.items() if f.type is not FeatureType.ACTION},
        output_features={k: f for k, f in features.items() if f.type is FeatureType.ACTION},
        chunk_size=10, n_action_steps=10, dim_model=64, dim_feedforward=128, n_heads=2,
        n_encoder_layers=1, n_vae_encoder_layers=1, device="cpu",
    )
)
stats = dataset.meta.stats
def normalised(batch, key):
    mean, std = (torch.as_tensor(stats[key][s], dtype=torch.float32) for s in ("mean", "std"))
    return (batch[key] - mean) / (std + 1e-3)
losses = []
optimiser = torch.optim.Adam(policy.parameters(), lr=1e-3)
loader = torch.utils.data.DataLoader(dataset, batch_size=32, shuffle=True)
for step, batch in zip(range(12), loader):
    keys = ("observation.state", "observation.environment_state", "action")
    loss, _ = policy.forward(
        {key: normalised(batch, key) for key in keys} | {"action_is_pad": batch["action_is_pad"]}
    )
    optimiser.zero_grad(); loss.backward(); optimiser.step()
    losses.append(loss.item())
assert sum(losses[-3:]) < sum(losses[:3]), losses
print("losses", losses[0], losses[-1])
"""


@pytest.fixture(scope="module")
def stored(task, demonstrations, tmp_path_factory):
    path = tmp_path_factory.mktemp("sets") / "demonstrations"
    write_demonstrations(demonstrations[:2], task, path)
    return path


@pytest.fixture(scope="module")
def replay_set(task, demonstrations, tmp_path_factory):
    path = tmp_path_factory.mktemp("sets") / "kp128_kd8"
    control = make_control({"kind": "joint_target"}, Cell(128, 8), task.robot, task.model)
    replays = replay(task, demonstrations[:3], control, decimation=10, threads=2)
    write_dataset([r.episode for r in replays], task, control.actions.names, 50, path)
    return path


def test_demonstrations_survive_the_disk_to_the_last_bit(task, demonstrations, stored):
    for a, b in zip(demonstrations[:2], read_demonstrations(stored, task), strict=True):
        np.testing.assert_array_equal(a.torque, b.torque)
        np.testing.assert_array_equal(a.dq, b.dq)
        np.testing.assert_array_equal(a.gripper, b.gripper)
        np.testing.assert_array_equal(a.qpos, b.qpos)


def test_so_do_those_of_two_arms(tmp_path):
    content = yaml.safe_load((ROOT / "config/tasks/bimanual_handover.yaml").read_text())
    task, rng = make_task(content), np.random.default_rng(0)
    sizes = task.model.nq, len(task.robot.joints), len(task.robot.joints), len(task.robot.grippers)
    made = Demonstration(*(rng.normal(size=(9, size)) for size in sizes))
    write_demonstrations([made], task, tmp_path / "set")
    (read,) = read_demonstrations(tmp_path / "set", task)
    for field in ("qpos", "dq", "torque", "gripper"):
        np.testing.assert_array_equal(getattr(read, field), getattr(made, field))


def test_lerobot_trains_on_a_replay_set(replay_set, tmp_path):
    environment = {**os.environ, "HF_HUB_OFFLINE": "1", "HF_HOME": str(tmp_path)}
    done = subprocess.run(
        [sys.executable, "-c", TRAIN_WITH_LEROBOT, str(replay_set)],
        capture_output=True,
        text=True,
        env=environment,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    assert "losses" in done.stdout


def _cut(path):
    file = next(path.glob("data/*/*.parquet"))
    file.write_bytes(file.read_bytes()[:-100])


def _foreign(path):
    info = json.loads((path / "meta/info.json").read_text())
    info["features"]["observation.state"]["shape"] = [3]
    (path / "meta/info.json").write_text(json.dumps(info))


def _other_robot(path):
    """Of as many joints."""
    file = path / "meta/info.json"
    file.write_text(file.read_text().replace("fr3_joint3", "panda_joint3"))


def _info(**changes):
    def change(path):
        file = path / "meta/info.json"
        file.write_text(json.dumps(json.loads(file.read_text()) | changes))

    return change


def _table(change):
    def rewrite(path):
        file = next(path.glob("data/*/*.parquet"))
        pq.write_table(change(pq.read_table(file)), file)

    return rewrite


def _shorter(table):
    lists = table["action"].to_pylist()
    lists[3] = lists[3][:-1]
    at = table.column_names.index("action")
    return table.set_column(at, "action", pa.array(lists, pa.list_(pa.float64())))


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (_cut, "file-000.parquet: cannot be read"),
        (_foreign, "observation.state has shape"),
        (_other_robot, "observation.state holds q.panda_joint3; expected q.fr3_joint3"),
        (lambda path: (path / "meta/info.json").unlink(), "meta/info.json: no such file"),
        (
            lambda path: (path / "meta/info.json").write_text("{"),
            "info.json: found what is not JSON",
        ),
        (lambda path: shutil.rmtree(path / "data"), "data"),
        (_info(features=[1]), "meta/info.json: makes no sense"),
        (_info(features={"action": 1}), "meta/info.json: makes no sense"),
        (_info(total_frames="many"), "frames where info.json says many"),
        (lambda path: (path / "meta/info.json").write_text("[]"), "meta/info.json: a list"),
        (_table(lambda table: table.drop_columns("action")), "lacks column action"),
        (_table(_shorter), "action has lists of other lengths"),
    ],
    ids=[
        *(
            "cut",
            "foreign",
            "other robot",
            "no info",
            "broken info",
            "no data",
            "features",
            "shapes",
            "total",
        ),
        *("list", "column", "lengths"),
    ],
)
def test_a_damaged_set_is_named(task, stored, tmp_path, damage, message):
    path = tmp_path / "damaged"
    shutil.copytree(stored, path)
    damage(path)
    with pytest.raises(ArtefactError, match=message) as error:
        read_demonstrations(path, task)
    assert str(path) in str(error.value)
    assert error.value.path == path


def test_a_set_is_not_written_over_another(task, demonstrations, tmp_path):
    """Snakemake removes what a job makes anew; nobody else's folder is removed."""
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes.txt").touch()
    with pytest.raises(OutputError, match="mine: cannot be written: a folder is there"):
        write_demonstrations(demonstrations[:1], task, tmp_path / "mine")
    assert [p.name for p in tmp_path.rglob("*")] == ["mine", "notes.txt"]
