"""Real, small trainings that are killed half-way go on to the policy of one that was not."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
import torch
import yaml

from t2l.gains import Cell
from t2l.rl.alone import depends_on, problem_of, settings_of, train_alone
from t2l.rl.side_by_side import Training, learn_side_by_side
from t2l.rl.unfinished import Unfinished
from tests.conftest import ROOT
from tests.defaults import DEFAULTS

# contacts and a gripper; pushes and noise; a floating base, feet that carry on, falls; a hand
TASKS = {
    "lift_cube": Cell(16, 24), "pose_hold": Cell(128, 16), "track_velocity": Cell(0.25, 4),
    "in_hand_cube": Cell(0.25, 4),
}  # fmt: skip
SMALL = {
    "environments": 8, "updates": 7, "evaluate_every": 2, "horizon_s": 1.0, "policy_rate_hz": 50.0,
    "rate_hz": 200.0, "observation_noise_rad": 0.01, "observation_noise_rad_s": 0.01,
}  # fmt: skip
STOPPED_AT = 6
KILLED = """
import sys, time
from tests.rl.test_unfinished import STOPPED_AT, learn

def wait(update, policy, evaluation):
    if update == STOPPED_AT:
        print("here", flush=True)
        time.sleep(600)

learn(sys.argv[1], sys.argv[2], wait)
"""


def asked(task):
    cell = TASKS.get(task, Cell(128, 16))
    scale = {"kp": cell.kp, "kd": cell.kd, "rad": [0.5, 0.2]}
    entry = {"task": task, "actions": {"kind": "joint_delta"}, "action_scales": [scale], **SMALL}
    parameters = yaml.safe_load((ROOT / f"config/tasks/{task}.yaml").read_text())
    section = {k: v for k, v in DEFAULTS["reinforcement_learning"].items() if k != "horizon_s"}
    return *problem_of(entry, parameters, cell), settings_of(section, entry)


def learn(task, path=None, report=lambda update, policy, evaluation: None):
    problem, choice, settings = asked(task)
    unfinished = path and Unfinished(path, depends_on(problem, choice, settings, 1))
    return train_alone(problem, choice, settings, 1, report, unfinished=unfinished)


def assert_same_training(one, other):
    histories = (each.history.drop(columns="seconds") for each in (one, other))
    pd.testing.assert_frame_equal(*histories, check_exact=True)
    for name, tensor in other.policy.tensors().items():
        np.testing.assert_array_equal(one.policy.tensors()[name], tensor, strict=True)


@pytest.mark.skipif(torch.cuda.is_available(), reason="digits of the processor")
@pytest.mark.parametrize("task", TASKS)
def test_a_killed_training_goes_on_to_the_same_digits(tmp_path, task):
    path = tmp_path / "unfinished.pt"
    process = subprocess.Popen(
        [sys.executable, "-c", KILLED, task, path], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout.readline() == "here\n"
    process.kill()
    process.wait()
    # no draft beside it
    assert [p.name for p in tmp_path.iterdir()] == ["unfinished.pt"]
    told = []
    trained, row, episodes = learn(task, path, lambda update, *_: told.append(update))
    # update 6 was judged, and what came of it was not kept
    assert told == [6, 7]
    whole, expected, shown = learn(task)
    assert_same_training(trained, whole)
    assert {**row, "seconds": 0} == {**expected, "seconds": 0}
    np.testing.assert_array_equal(np.stack(episodes.qpos), np.stack(shown.qpos))


@pytest.mark.parametrize(("device", "count"), [("mujoco", 1), ("mujoco", 2), ("cpu", 2)])
def test_so_do_those_that_are_trained_as_on_a_gpu(tmp_path, device, count):
    class StoppedError(Exception):
        """In place of a kill."""

    def stop(update, policy, evaluation):
        if update == STOPPED_AT:
            raise StoppedError

    problem, choice, settings = asked("joint_reach")
    told = []
    whole, stopped, going_on = (
        [
            Training(
                problem, choice, replace(settings, seed=seed), report,
                Unfinished(tmp_path / str(seed) / name, f"training {seed}"),
            )
            for seed in range(count)
        ]
        for name, report in (
            ("another.pt", lambda *_: None),
            ("unfinished.pt", stop),
            ("unfinished.pt", lambda update, *_: told.append(update)),
        )
    )  # fmt: skip
    with pytest.raises(StoppedError):
        learn_side_by_side(stopped, device=device)
    # they have one state
    assert [path.parent.name for path in tmp_path.rglob("unfinished.pt")] == ["0"]
    found = learn_side_by_side(going_on, device=device)
    assert told == [6] * count + [7] * count
    expected = learn_side_by_side(whole, device=device)
    for one, other in zip(found, expected, strict=True):
        assert_same_training(one, other)


def test_what_was_kept_of_another_training_or_is_broken_is_not_used(tmp_path):
    path = tmp_path / "unfinished.pt"
    problem, choice, settings = asked("pose_hold")
    one = Unfinished(path, depends_on(problem, choice, settings, 1))
    one.write({"updates": 2, "array": np.arange(3.0), "number": np.float64(0.5)})
    kept = one.read()
    assert kept["updates"] == 2
    assert kept["array"].tolist() == [0, 1, 2]
    assert kept["number"] == 0.5
    for changed in (
        depends_on(problem, choice, settings, 2),
        depends_on(problem, choice, replace(settings, updates=8), 1),
        depends_on(problem, replace(choice, action_scale=(0.5, 0.3)), settings, 1),
    ):
        assert Unfinished(path, changed).read() is None
    path.write_bytes(path.read_bytes()[:-100])
    assert one.read() is None
    one.remove()
    assert not path.exists()
