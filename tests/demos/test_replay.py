import numpy as np
import pytest
import yaml

from t2l.actions import make_control
from t2l.demos.expert import attempt
from t2l.demos.replay import replay, replay_table, successful
from t2l.errors import ReplayError
from t2l.gains import Cell
from t2l.tasks import make_task
from tests.conftest import ROOT


def control(task, cell, kind="joint_target", **section):
    return make_control({"kind": kind, **section}, cell, task.robot, task.model)


CORNERS = [Cell(kp, kd) for kp in (16, 512) for kd in (2, 24)]


@pytest.mark.parametrize("cell", CORNERS, ids=lambda cell: cell.name)
def test_at_500_hz_a_replay_reproduces_its_demonstration(task, demonstrations, cell):
    replays = replay(task, demonstrations[:4], control(task, cell), decimation=1, threads=2)
    assert all(r.success for r in replays)
    # 1e-11 rad²: what the solver's tolerance leaves of contacts and friction, 3 µrad
    assert max(r.mse_q_rad2 for r in replays) < 1e-11


def test_without_contact_and_friction_a_replay_is_exact_to_rounding(block_stack):
    free = make_task(block_stack)
    free.model.dof_frictionloss[:] = 0
    free.model.geom_contype[:] = free.model.geom_conaffinity[:] = 0
    starts = free.sample_starts(np.random.default_rng(0), 2)
    demonstrations, _ = attempt(free, starts, np.random.default_rng(1))
    for cell in CORNERS:
        replays = replay(free, demonstrations, control(free, cell), decimation=1)
        assert max(r.mse_q_rad2 for r in replays) < 1e-24


@pytest.mark.parametrize("cell", CORNERS, ids=lambda cell: cell.name)
def test_at_20_hz_retargeting_is_as_faithful_as_the_study_reports(task, demonstrations, cell):
    replays = replay(task, demonstrations, control(task, cell), decimation=25, threads=2)
    assert np.mean([r.success for r in replays]) >= 0.9
    assert np.mean([r.mse_q_rad2 for r in replays]) < 1e-3


def test_the_mean_hold_is_more_faithful_than_sampling(task, demonstrations):
    errors = {
        how: np.mean(
            [r.mse_q_rad2 for r in replay(task, demonstrations, control(task, CORNERS[0]), 25, how)]
        )
        for how in ("mean", "sample")
    }
    assert errors["mean"] < errors["sample"] / 10


def test_without_gravity_compensation_the_commands_carry_the_weight(block_stack):
    loaded = make_task({**block_stack, "gravity_compensation": False})
    starts = loaded.sample_starts(np.random.default_rng(0), 2)
    demonstrations, success = attempt(loaded, starts, np.random.default_rng(1), threads=2)
    assert success.all()
    # joints 2 and 4 hold up the arm: tens of N·m of a torque that averages out otherwise
    weight = np.abs(np.concatenate([d.torque for d in demonstrations]).mean(axis=0))
    assert weight[[1, 3]].min() > 10
    replays = replay(loaded, demonstrations, control(loaded, Cell(32, 8)), decimation=10, threads=2)
    assert all(r.success for r in replays)
    sag = np.concatenate([r.command - r.observation[:, :7] for r in replays]).mean(axis=0)
    assert np.abs(sag[[1, 3]]).min() > 10 / 32 * 0.8


def test_threads_do_not_change_a_replay(task, demonstrations):
    one, two = (
        replay(task, demonstrations[:3], control(task, Cell(128, 8)), 10, threads=n) for n in (1, 2)
    )
    for a, b in zip(one, two, strict=True):
        np.testing.assert_array_equal(a.observation, b.observation)


def test_a_cell_without_successful_replays_says_so(task, demonstrations):
    # commands at 1 Hz are too slow for anything
    cell = Cell(16, 2)
    replays = replay(task, demonstrations[:2], control(task, cell), decimation=500)
    table = replay_table(replays, cell)
    assert not table.success.any()
    assert (table.failure != "").all()
    with pytest.raises(ReplayError, match=r"Kp 16, Kd 2: 0 of 2"):
        successful(replays, cell)


@pytest.mark.parametrize(
    ("kind", "section"),
    [("joint_delta", {"reference": "measured"}), ("joint_delta", {"reference": "commanded"})],
)
def test_what_an_action_means_does_not_change_what_is_commanded(
    task, demonstrations, kind, section
):
    cell = Cell(128, 8)
    target = replay(task, demonstrations[:2], control(task, cell), 10)
    delta = replay(task, demonstrations[:2], control(task, cell, kind, **section), 10)
    for a, b in zip(target, delta, strict=True):
        np.testing.assert_array_equal(a.observation, b.observation)
        np.testing.assert_array_equal(a.action, a.command)
        measured = b.observation[:, : b.command.shape[1]]
        before = np.concatenate([measured[:1], b.command[:-1]])
        base = measured if section["reference"] == "measured" else before
        np.testing.assert_allclose(b.action, b.command - base, atol=1e-6)


# of the study's grid, 1/s² and 1/s; at Kp 32, Kd 128 some commands take more than half a turn
TASK_SPACE = [Cell(32, 1), Cell(32, 32), Cell(2048, 1), Cell(2048, 128)]


@pytest.mark.parametrize("cell", TASK_SPACE, ids=lambda cell: cell.name)
@pytest.mark.parametrize("kind", ["task_pose", "task_delta"])
def test_under_operational_space_control_a_replay_is_exact_to_rounding(
    task, demonstrations, kind, cell
):
    """The demonstrations' expert has the same null space, and the law is solved for the pose."""
    replays = replay(task, demonstrations[:2], control(task, cell, kind), decimation=1)
    assert all(r.success for r in replays)
    assert max(r.mse_q_rad2 for r in replays) < 1e-24


def test_each_of_two_arms_repeats_its_part_under_operational_space_control():
    content = yaml.safe_load((ROOT / "config/tasks/bimanual_handover.yaml").read_text())
    handover = make_task(content)
    starts = handover.sample_starts(np.random.default_rng(0), 1)
    demonstrations, _ = attempt(handover, starts, np.random.default_rng(1))
    replays = replay(handover, demonstrations, control(handover, Cell(128, 8), "task_pose"), 1)
    assert max(r.mse_q_rad2 for r in replays) < 1e-24
