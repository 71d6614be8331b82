"""Gains searched with real, tiny trainings, and a twin that steps as the loop of a log does."""

import subprocess
import sys
import time
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from optuna.trial import TrialState

from t2l.cli.main import main
from t2l.config.models.gain_search import GainSearchEntry
from t2l.errors import ConfigurationError, EffectError
from t2l.figures.pareto import write_search
from t2l.gains import Cell
from t2l.identify.model import Model
from t2l.identify.prediction import with_effects
from t2l.identify.simulation import at_every_tick
from t2l.policies.gaussian_mlp import GaussianMLP
from t2l.recordings import read_recording
from t2l.recordings.recording import CONTINUOUS
from t2l.rl.gain_search import check, confirm, of_entry, transfer_error, work
from t2l.rl.gain_table import gain_table, in_words, not_beaten
from t2l.rl.problem import Choice
from t2l.rl.side_by_side import Training
from t2l.rl.trials import count, open_study
from t2l.rl.twin import Machine, Twin
from t2l.sim.schedule import Schedule
from t2l.tasks.reach import JointReach
from t2l.tasks.terms import TerminationTerm
from t2l.typed import check as checked
from tests.defaults import DEFAULTS, shipped

TASK = shipped("joint_reach")
PARAMETERS = {"kind": "joint_reach", "robot": "fr3", "start_spread_rad": 0.1,
              "goal_spread_rad": 0.4, "tolerance_rad": 0.1}  # fmt: skip
SMALL = {
    "kp": [16, 512], "kd": [4, 32], "environments": 8, "updates": 2, "evaluate_every": 1,
    "horizon_s": 0.4, "startup": 2, "least_success": 0.0, "limits": ["velocity"],
}  # fmt: skip
FRICTION = dict.fromkeys(TASK.robot.joints, 3.0)  # N·m·s/rad
BARE = Machine(Model("fr3"), 1000.0, CONTINUOUS)
KILLED = """
import sys
from tests.rl.test_gain_search import asked, opened, work
given = asked(trials=1, updates=100000)
work(opened(sys.argv[1], *given), *given, 0)
"""


def asked(machine=None, **changes):
    entry = checked(GainSearchEntry, {**SMALL, **changes}).model_dump()
    learning = DEFAULTS["reinforcement_learning"]
    return of_entry(entry, "joint_reach", PARAMETERS, learning, machine)


def opened(folder, problem, search, settings):
    name = problem.study_name(search, settings, 0)
    return open_study("journal", f"{folder}/trials.journal", name, [*problem.objectives.values()])


def searched(folder, machine=None, **changes):
    given = asked(machine, **changes)
    study = opened(folder, *given)
    work(study, *given, 0)
    return study, given


@given(st.lists(st.tuples(*[st.integers(0, 4)] * 3, st.booleans()), min_size=1, max_size=12))
def test_nothing_allowed_beats_a_row_of_the_front_and_something_in_it_beats_every_other(rows):
    costs = np.array([row[:3] for row in rows], float)
    allowed = np.array([row[3] for row in rows])

    def beats(one, other):
        return (costs[one] <= costs[other]).all() and (costs[one] < costs[other]).any()

    front = not_beaten(costs, allowed)
    assert not (front & ~allowed).any()
    for i in np.flatnonzero(front):
        assert not any(beats(j, i) for j in np.flatnonzero(allowed))
    for i in np.flatnonzero(allowed & ~front):
        assert any(beats(j, i) for j in np.flatnonzero(front))


def test_a_search_continues_as_if_it_had_never_stopped(tmp_path):
    whole, given = searched(tmp_path / "whole", trials=4)
    searched(tmp_path / "parts", trials=2)
    parts, _ = searched(tmp_path / "parts", trials=4)
    for one, other in zip(whole.trials, parts.trials, strict=True):
        assert (one.params, one.values) == (other.params, other.values)
    problem, search, settings = given
    confirm(whole, problem, search, settings)
    table = gain_table(whole, problem.objectives)
    assert set(table.columns) >= {"kp", "kd", "action_scale_distal", "effort", "velocity"}
    front = table[table.front]
    # policies from other seeds, of the front alone
    assert (front.again == 1).all()
    assert (front.effort_again != front.effort).all()
    assert (table[~table.front].again == 0).all()
    said = []
    confirm(whole, problem, search, settings, report=said.append)
    assert not said
    write_search(table, tmp_path)
    assert (tmp_path / "front.csv").read_text().count("\n") == 1 + len(front)
    assert (tmp_path / "figures/front.png").stat().st_size > 10_000
    assert in_words(table, problem.objectives).startswith(f"The front, {len(front)} of 4")


def test_a_trial_of_a_killed_search_is_run_again(tmp_path):
    process = subprocess.Popen([sys.executable, "-c", KILLED, str(tmp_path)])
    given = asked(trials=1, updates=100000)
    until = time.monotonic() + 120
    while not (study := opened(tmp_path, *given)).trials:
        assert process.poll() is None
        assert time.monotonic() < until
        time.sleep(0.2)
    while not study.trials[0].user_attrs.get("action_scale_distal"):
        time.sleep(0.1)
    process.kill()
    process.wait()
    chosen, said = study.trials[0].params, []
    # the same search, of which a test sees the end
    work(study, *given[:2], replace(given[2], updates=1), 0, report=said.append)
    assert said[0] == "trial 0 was left unfinished and is run again"
    assert [t.state for t in study.trials] == [TrialState.FAIL, TrialState.COMPLETE]
    assert study.trials[1].params == chosen


def test_gains_that_are_unstable_at_the_loops_rate_are_not_trained(tmp_path):
    study, (problem, *_) = searched(
        tmp_path, trials=6, startup=6, kd=[4, 4000], control_rate_hz=500, updates=1
    )
    table = gain_table(study, problem.objectives)
    unstable = table.error.notna() & table.error.fillna("").str.contains("unstable at 500 Hz")
    assert 0 < unstable.sum() < 6
    # from some damping on, whatever the stiffness
    assert table[unstable].kd.min() > table[~unstable].kd.max()
    assert not table[unstable].front.any()
    assert count(study, TrialState.PRUNED) == unstable.sum()
    assert "allowed: a step of at most" in table[unstable].error.iloc[0]


@pytest.mark.parametrize("compensation", [True, CONTINUOUS])
@pytest.mark.parametrize(
    "effects", [{}, {"command_delay": {"delay": 0.0135}, "viscous_friction": {"damping": FRICTION}}]
)
def test_a_twin_steps_as_the_loop_of_a_log(compensation, effects):
    rng = np.random.default_rng(0)
    commands = TASK.robot.home + np.cumsum(rng.normal(0, 0.01, (25, 2, 7)), axis=0)
    commands[0] = TASK.robot.home
    kp, kd, model = np.full(7, 200.0), np.full(7, 12.0), Model("fr3", effects)
    every = np.ones(2, bool)
    schedule = Schedule(
        period_s=1e-3, commands=np.repeat(commands, 20, axis=0), kp=np.tile(kp, (2, 1)),
        kd=np.tile(kd, (2, 1)), start_q=commands[0], start_dq=np.zeros((2, 7)),
        compensated=every & (compensation is True), balanced=every & (compensation == CONTINUOUS),
        sample_ticks=np.array([499]), command_period_s=np.full(2, 0.02),
    )  # fmt: skip
    joints = TASK.robot.joints
    simulated = with_effects("fr3", joints, []), joints, schedule, 1, *model.vector(joints)
    expected, _ = at_every_tick(*simulated)
    machine = replace(BARE, model=model, gravity_compensation=compensation)
    twin = Twin(machine, TASK, kp, kd, 2, 50.0, 0.5)
    twin.begin(np.arange(2), commands[0])
    found = []
    for command in commands:
        for _ in range(20):
            found.append(twin.q.copy())
            twin.step(command, 1)
    np.testing.assert_allclose(np.array(found), expected, atol=1e-12, rtol=0)


def test_the_error_of_transfer_is_that_of_what_the_twin_has_beyond_the_simulator():
    def error(**effects):
        machine = replace(BARE, model=Model("fr3", effects))
        problem, search, settings = asked(machine)
        check(problem, search, settings)
        training = Training(problem.at(Cell(100, 12)), Choice((0.1, 0.1)), settings)
        return transfer_error(problem, training, POLICY)

    torque = {joint: 2.0 for joint in TASK.robot.joints}
    bare, rubbing = error(), error(coulomb_friction={"torque": torque})
    assert 0 < bare < rubbing
    assert bare < error(command_delay={"delay": 0.05})


def test_a_twin_that_cannot_follow_is_no_end_of_a_search(tmp_path):
    """An effect that a simulation has no column for is told before any training."""
    machine = replace(
        BARE,
        model=Model(
            "fr3",
            {
                "torque_constant_temperature": {
                    name: dict.fromkeys(TASK.robot.joints, value)
                    for name, value in (("factor", 1.0), ("per_kelvin", 0.01))
                }
            },
        ),
    )
    with pytest.raises(EffectError, match="temperature"):
        check(*asked(machine))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["joint_reachh"], "did you mean joint_reach"),
        (["block_stack"], "allowed: joint_reach"),
        (["joint_reach", "--robot", "fr4"], "fr4"),
        (["joint_reach", "--kp", "512,16"], "--kp: found"),
        (["joint_reach", "--limits", "speed"], "--limits"),
        (["joint_reach", "--rate-hz", "130"], "policy rate: found 50 Hz"),
        (["joint_reach", "--evaluate-every", "99"], "evaluate_every: found 99"),
        (["joint_reach", "--control-rate-hz", "20"], "unstable at 20 Hz"),
        (["joint_reach", "--model", "m.yaml"], "no --logs beside it"),
        (["joint_reach", "--logs", "examples/two_joint_arm/train"], "robot of the recordings"),
        (
            ["lift_cube", "--logs", "nowhere"],
            "lift_cube: found objects or a hand.* allowed: no rec",
        ),
        (["pose_hold", "--logs", "nowhere"], "pose_hold: found forces from outside.* allowed: no"),
    ],
)
def test_what_is_wrong_is_said_before_a_trial(tmp_path, arguments, message):
    task, *others = arguments
    given = ["tune", task, "--kp", "16,512", "--kd", "4,32", *others, "--out", f"{tmp_path}/out"]
    with pytest.raises(SystemExit, match=message):
        main(given)
    assert not (tmp_path / "out").exists()


def test_a_task_whose_episodes_end_early_has_no_twin():
    """Once the episode of one of two motions has ended, there is nothing to compare."""

    class Stopping(JointReach):
        terminations = (TerminationTerm("far", lambda at: np.abs(at.q[:, 0]) > 2.0),)

    task = Stopping(**{k: v for k, v in PARAMETERS.items() if k != "kind"})
    with pytest.raises(ConfigurationError, match=r"end early \(far\).* such as joint_reach"):
        Twin(BARE, task, np.full(7, 100.0), np.full(7, 12.0), 1, 50.0, 0.4)


def test_recordings_of_several_loops_make_no_twin():
    one = read_recording("examples/two_joint_arm/train/medium_steps.csv")
    other = replace(one, control_rate_hz=250.0)
    robot = SimpleNamespace(name=one.robot, joints=one.joints)
    with pytest.raises(ConfigurationError, match="a twin has one loop"):
        Machine.of(Model(one.robot), [one, other], robot)


def _policy():
    """It asks for its goal: error over scale, joint by joint."""
    n, nobs = 7, 28
    weights = np.zeros((n, nobs), np.float32)
    weights[:, 14:21] = 5 * np.eye(n)
    return GaussianMLP(
        mean=np.zeros(nobs, np.float32), deviation=np.ones(nobs, np.float32),
        weights=[weights], biases=[np.zeros(n, np.float32)],
        action_scale=np.full(n, 0.1), clipped=True,
    )  # fmt: skip


POLICY = _policy()
