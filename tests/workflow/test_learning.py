"""Tasks with contacts are learned from a configuration alone."""

import pandas as pd
from matplotlib.image import imread

from t2l.policies import checkpoint

SMALL = {"environments": 8, "updates": 2, "evaluate_every": 1, "horizon_s": 0.2}
LEARNING = {
    "study": "learned",
    "learning": {
        "tasks": [
            {
                "task": "lift_cube",
                "action_scales": [{"kp": 16, "kd": 24, "rad": [2.0, 1.0]}],
                **SMALL,
            },
            {
                "task": "track_velocity",
                "actions": {"kind": "joint_delta", "reference": "home"},
                "action_scales": [{"kp": 0.25, "kd": 4, "rad": [1.0, 0.5]}],
                **SMALL,
            },
        ]
    },
    "sim_to_real": {"conditions": []},
}


def test_a_task_with_contacts_is_learned_judged_and_shown(empty_project):
    done = empty_project.run("--", "learning", config=LEARNING)
    assert done.returncode == 0, done.stdout
    results = empty_project.folder / "results/learned"
    lift, walk = pd.read_csv(results / "tables/learning.csv").to_dict("records")
    assert (lift["task"], lift["kp"], lift["episodes"], lift["exists"]) == (
        "lift_cube", 16, 100, False,
    )  # fmt: skip
    # in a fifth of a second nobody falls
    assert (walk["task"], walk["kp"], walk["kd"], walk["failed"]) == ("track_velocity", 0.25, 4, 0)
    for figure in ("learning", "lift_cube_learned", "track_velocity_learned"):
        assert imread(results / f"figures/{figure}.png")[..., :3].std() > 0.02
    policy = results / "learning/lift_cube/kp16_kd24/seed1"
    assert checkpoint.load(policy / "policy.safetensors").action_size == 8
    history = pd.read_parquet(policy / "training.parquet")
    assert history.steps.tolist() == [24 * 8, 2 * 24 * 8]
    assert {"reward_reaching", "reward_lifting", "reward_goal"} <= set(history.columns)
    # a user sees which term fails while it trains
    logs = [log.read_text() for log in sorted((results / "logs/learn").iterdir())]
    assert all("update 2: success 0.00, ended early 0.00; reward" in log for log in logs)
    assert ["stepping" in log for log in logs] == [False, True]
    assert "reaching" in logs[0]
