"""Tasks with contacts are learned from a configuration alone."""

import os
import signal
import subprocess
import time

import pandas as pd
from matplotlib.image import imread

from t2l.policies import checkpoint
from t2l.rl.results import read_chosen

SMALL = {"environments": 8, "updates": 2, "evaluate_every": 1, "horizon_s": 0.2}
LEARNING = {
    "study": "learned",
    "learning": {
        "episodes": 20,
        "tasks": [
            {
                "task": "lift_cube",
                "action_scales": [
                    {"kp": kp, "kd": kd, "rad": [2.0, 1.0]} for kp in (16, 512) for kd in (2, 24)
                ],
                **SMALL,
            },
            {
                "task": "joint_reach",
                "searched": [{"kp": 128, "kd": 16}],
                **SMALL,
            },
            {
                "task": "track_velocity",
                "actions": {"kind": "joint_delta", "reference": "home"},
                "action_scales": [{"kp": 0.25, "kd": 4, "rad": [1.0, 0.5]}],
                **SMALL,
            },
        ],
        "gain_searches": [
            {
                "task": "joint_reach",
                "kp": [64, 512],
                "kd": [4, 16],
                "trials": 2,
                "startup": 2,
                "least_success": 0.0,
                "limits": [],
                **{**SMALL, "horizon_s": 0.4},
            },
        ],
    },
    "sim_to_real": {"conditions": []},
}


def test_a_task_with_contacts_is_learned_judged_and_shown(empty_project):
    done = empty_project.run("--", "learning", config=LEARNING)
    assert done.returncode == 0, done.stdout
    results = empty_project.folder / "results/learned"
    reach, *lifts, walk = pd.read_csv(results / "tables/learning.csv").to_dict("records")
    for lift in lifts:
        assert (lift["task"], lift["episodes"], lift["exists"]) == ("lift_cube", 20, False)
    # of the task that is asked for at four corners
    corners = pd.read_csv(results / "tables/existence.csv")
    assert corners.task.unique().tolist() == ["lift_cube"]
    assert corners.region.tolist() == ["CO", "CU", "SO", "SU"]
    assert (corners.episodes == 20).all()
    assert not corners.exists.any()
    # in a fifth of a second nobody falls
    assert (walk["task"], walk["kp"], walk["kd"], walk["failed"]) == ("track_velocity", 0.25, 4, 0)
    for figure in (
        "learning",
        "existence",
        "joint_reach_learned",
        "lift_cube_learned",
        "track_velocity_learned",
    ):
        assert imread(results / f"figures/{figure}.png")[..., :3].std() > 0.02
    policy = results / "learning/lift_cube/kp16_kd24/seed1"
    assert checkpoint.load(policy / "policy.safetensors").action_size == 8
    history = pd.read_parquet(policy / "training.parquet")
    assert history.steps.tolist() == [24 * 8, 2 * 24 * 8]
    assert {"reward_reaching", "reward_lifting", "reward_goal"} <= set(history.columns)
    # a user sees which term fails while it trains
    logs = [log.read_text() for log in sorted((results / "logs/learn").iterdir())]
    assert all("update 2: success 0.00, ended early 0.00; reward" in log for log in logs)
    assert ["stepping" in log for log in logs] == [False] * 5 + [True]
    assert "reaching" in logs[1]
    assert (reach["task"], reach["kp"]) == ("joint_reach", 128)
    (trials,) = pd.read_csv(results / "tables/learning_trials.csv").to_dict("records")
    assert (trials["task"], trials["trials"], trials["passed"]) == ("joint_reach", 2, 0)
    cell = results / "learning/joint_reach/kp128_kd16"
    _, choice = read_chosen(cell / "chosen.yaml")
    policy = checkpoint.load(cell / "seed1/policy.safetensors")
    assert set(policy.action_scale) == set(choice.action_scale)
    tried = pd.read_parquet(cell / "trials.parquet").filter(like="action_scale_")
    assert choice.action_scale in set(tried.itertuples(index=False, name=None))
    searched = results / "learning/joint_reach/gains"
    assert len(pd.read_csv(searched / "trials.csv")) == 2
    # each trial of the front was trained again, from another seed
    front = pd.read_csv(searched / "front.csv")
    assert len(front)
    assert (front.again == 1).all()
    assert imread(searched / "figures/front.png")[..., :3].std() > 0.02


def test_a_training_that_was_killed_goes_on(empty_project):
    scale = {"kp": 128, "kd": 16, "rad": [0.2, 0.1]}
    pose = {**SMALL, "task": "pose_hold", "action_scales": [scale], "updates": 200}
    config = {"study": "killed", "learning": {"tasks": [pose]}, "sim_to_real": {"conditions": []}}
    policy = "results/killed/learning/pose_hold/kp128_kd16/seed1/policy.safetensors"
    unfinished = (empty_project.folder / policy).with_name("unfinished.pt")
    command = empty_project.command("--", policy, config=config)
    run = subprocess.Popen(command, cwd=empty_project.folder, start_new_session=True)
    until = time.monotonic() + 120
    while not unfinished.exists():
        assert run.poll() is None
        assert time.monotonic() < until
        time.sleep(0.05)
    os.killpg(run.pid, signal.SIGKILL)
    run.wait()
    assert not (empty_project.folder / policy).exists()
    done = empty_project.run("--", policy, config=config)
    assert done.returncode == 0, done.stdout
    log = (
        empty_project.folder / "results/killed/logs/learn/pose_hold_kp128_kd16_1.log"
    ).read_text()
    assert "goes on after update" in log
    assert "update 1: " not in log
    made = {path.name for path in unfinished.parent.iterdir()}
    assert made == {
        "policy.safetensors", "training.parquet", "outcome.parquet", "episodes.parquet",
    }  # fmt: skip
    history = pd.read_parquet(unfinished.with_name("training.parquet"))
    assert history["update"].tolist() == list(range(1, 201))
