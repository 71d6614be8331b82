"""Tuning with real, tiny trainings, and real Optuna storages."""

import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import optuna
import pytest
import yaml
from optuna.trial import TrialState

from t2l.environment.interface import scale_per_joint
from t2l.errors import ArtefactError, ConfigurationError
from t2l.gains import Cell
from t2l.rl.problem import Choice, Condition, Problem
from t2l.rl.trials import (
    StorageError,
    TuningError,
    best,
    count,
    open_study,
    requeue_abandoned,
    sign,
    table,
)
from t2l.rl.tuning import choose, first_guess, work
from tests.defaults import TASKS, learning, search
from tests.rl.test_environments import CENTRE, PARAMETERS, ROBOT

TINY = learning(environments=8, updates=2, evaluate_every=1)
PROBLEM = Problem(
    Condition(
        name="joint_reach",
        task="joint_reach",
        policy_rate_hz=50.0,
        randomisation=0.0,
        actions={"kind": "joint_delta"},
        parameters=yaml.safe_load((TASKS / "joint_reach.yaml").read_text()),
    ),
    Cell(128, 16),
    PARAMETERS,
    100,
    horizon_s=0.4,
)
KILLED = """
import sys
from pathlib import Path
from t2l.rl.trials import open_study
from t2l.rl.tuning import work
from tests.defaults import learning, search
from tests.rl.test_tuning import PROBLEM
folder = Path(sys.argv[1])
study = open_study("journal", folder / "trials.journal", "s")
forever = learning(environments=8, updates=100000, evaluate_every=1)
work(study, PROBLEM, search(trials=1), forever, 0)
"""


def run(folder, trials, storage="journal", name="s", settings=TINY, problem=PROBLEM):
    study = open_study(storage, folder / "trials.journal", name)
    work(study, problem, search(trials=trials, startup=2), settings, seed=0)
    return study


def test_a_study_continues_as_if_it_had_never_stopped(tmp_path):
    whole = run(tmp_path / "whole", 4)
    run(tmp_path / "parts", 2)
    parts = run(tmp_path / "parts", 4)
    for one, other in zip(whole.trials, parts.trials, strict=True):
        assert one.params == other.params
        assert one.value == other.value
    found = best(parts, ROBOT, 4)
    assert found.evaluation.objective == max(t.value for t in parts.trials)
    rows = table(parts)
    assert list(rows.number) == [0, 1, 2, 3]
    assert np.isfinite(rows[["success", "torque_rate", "action_scale_distal"]]).all(axis=None)


def test_trials_are_ranked_by_what_the_search_says(tmp_path):
    study = open_study("journal", tmp_path / "trials.journal", "s")
    work(study, PROBLEM, search(trials=3, startup=2, solved_at=0.9), TINY, seed=0)
    for trial in study.trials:
        # trainings of two updates solve nothing: each is worth its success, whatever it keeps
        assert trial.value == trial.user_attrs["success"] < 0.9
    assert best(study, ROBOT, 3).evaluation.success == max(t.value for t in study.trials)


@pytest.mark.parametrize("cell", [Cell(16, 1), Cell(16, 24), Cell(512, 1), Cell(512, 24)])
def test_the_first_guess_moves_every_joint_within_the_torque_limits(cell):
    parameters = {
        **PARAMETERS, "stiffness": np.full(7, float(cell.kp)), "damping": np.full(7, float(cell.kd))
    }  # fmt: skip
    problem = Problem(PROBLEM.condition, cell, parameters, 100, horizon_s=2.0)
    guess = first_guess(problem, search(trials=1))
    scales = tuple(guess[name] for name in ("action_scale_proximal", "action_scale_distal"))
    assert scales[0] * cell.kp <= 0.5 * 87 + 1e-9
    assert scales[1] * cell.kp <= 0.5 * 12 + 1e-9
    # nor a jump that the limit of the torque's rate, 990 N·m/s at 100 Hz, forbids
    assert max(scales) * cell.kp <= 9.9 + 1e-9
    environments = problem.environments(Choice(scales), TINY, 7, seed=0)
    environments.place(start := np.tile(CENTRE, (7, 1)), start)
    for _ in range(50):
        environments.step(np.eye(7))
    moved = np.diag(environments.simulator.q - start)
    assert (moved > 0.1).all()


def test_a_study_begins_with_the_first_guess(tmp_path):
    study = run(tmp_path, 1)
    assert study.trials[0].params == pytest.approx(first_guess(PROBLEM, search(trials=1)))


def test_a_trial_of_a_killed_process_is_run_again(tmp_path):
    process = subprocess.Popen([sys.executable, "-c", KILLED, str(tmp_path)])
    study = open_study("journal", tmp_path / "trials.journal", "s")
    waited = time.monotonic()
    while not any(t.intermediate_values for t in study.trials):
        assert process.poll() is None
        assert time.monotonic() - waited < 120
        time.sleep(0.2)
    assert requeue_abandoned(study) == []  # it is still at work
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    params = study.trials[0].params
    study = run(tmp_path, 1)
    states = [trial.state for trial in study.trials]
    assert states == [TrialState.FAIL, TrialState.COMPLETE]
    assert study.trials[1].params == params


def test_workers_share_a_study(tmp_path):
    study = open_study("journal", tmp_path / "trials.journal", "s")
    other = study.ask()  # a living process is at work on the last of two
    sign(other)
    run(tmp_path, 2)
    assert count(study, TrialState.COMPLETE) == 1
    with pytest.raises(TuningError, match="found 1 trials that finished"):
        best(study, ROBOT, 2)


def test_a_database_will_do(tmp_path):
    url = f"sqlite:///{tmp_path / 'trials.db'}"
    study = run(tmp_path, 1, storage=url)
    assert optuna.load_study(study_name="s", storage=url).best_value == study.best_value


@pytest.mark.parametrize(
    "url",
    ["postgresql://me:secret@127.0.0.1:1/db", "sqlite:////no/such/folder/trials.db", "nonsense"],
)
def test_a_storage_that_does_not_answer_is_named(tmp_path, url):
    with pytest.raises(StorageError, match="cannot be used") as caught:
        open_study(url, tmp_path / "trials.journal", "s")
    assert "secret" not in str(caught.value)
    assert "allowed: journal, or the URL of a database" in str(caught.value)


def test_a_policy_that_is_not_finite_is_a_hopeless_trial(tmp_path):
    # no simulator steps through this
    wild = {**PARAMETERS, "armature": np.full(7, np.nan)}
    problem = Problem(PROBLEM.condition, PROBLEM.cell, wild, 100, horizon_s=0.4)
    study = run(tmp_path, 2, problem=problem)
    assert [trial.state for trial in study.trials] == [TrialState.PRUNED] * 2
    assert "not finite" in study.trials[0].user_attrs["error"]
    with pytest.raises(TuningError, match="0 of them with a policy"):
        best(study, ROBOT, 2)


def test_another_problem_is_another_study_and_more_trials_are_not():
    def name(**changes):
        return replace(PROBLEM, **changes).study_name(search(trials=3), TINY, 0)

    assert name() == PROBLEM.study_name(search(trials=50), TINY, 0)
    assert name() != name(cell=Cell(64, 16))
    assert name() != name(parameters={**PARAMETERS, "armature": np.full(7, 0.2)})
    assert name() != PROBLEM.study_name(search(trials=3), TINY, 1)


@pytest.mark.parametrize("cut", [1, 10, -1], ids=["a byte", "ten bytes", "all but the newline"])
def test_a_journal_whose_last_line_was_cut_by_a_kill_goes_on(tmp_path, cut):
    study = run(tmp_path, 1)
    path = tmp_path / "trials.journal"
    whole = path.read_bytes()
    study.set_user_attr("note", 1)  # what a killed process was about to say
    last = path.read_bytes().splitlines(keepends=True)[-1]
    path.write_bytes(path.read_bytes()[: -len(last)] + last[:cut])
    again = run(tmp_path, 2)
    assert path.read_bytes().startswith(whole)
    assert count(again, TrialState.COMPLETE, TrialState.PRUNED) == 2
    assert len(open_study("journal", path, "s").trials) == 2


@pytest.mark.parametrize(
    "damage",
    [
        lambda content: b"no journal",
        lambda content: b"[]\n",
        lambda content: b"{}\n",
        lambda content: b"\xff\x00\n" * 3,
        lambda content: content[:200] + content[250:],
        lambda content: content[:200] + b"\x00" * 50 + content[250:],
        lambda content: b'{"op_code":99,"worker_id":"w"}\n' + content,
        lambda content: b'{"op_code":4}\n' + content,
    ],
    ids=["text", "list", "object", "bytes", "hole", "zeros", "unknown", "lacking"],
)
def test_a_journal_that_is_none_is_named(tmp_path, damage):
    study = open_study("journal", path := tmp_path / "trials.journal", "s")
    study.tell(study.ask({"x": optuna.distributions.FloatDistribution(0, 1)}), 1.0)
    path.write_bytes(damaged := damage(path.read_bytes()))
    with pytest.raises(ArtefactError, match=r"trials.journal: .* a journal of Optuna") as caught:
        open_study("journal", path, "s")
    assert caught.value.path == path
    assert path.read_bytes() == damaged


def test_a_folder_in_the_place_of_a_journal_is_named(tmp_path):
    (tmp_path / "trials.journal").mkdir()
    with pytest.raises(ArtefactError, match=r"trials.journal: no regular file"):
        open_study("journal", tmp_path / "trials.journal", "s")


def test_the_lock_of_a_killed_process_leads_to_the_journal(tmp_path, monkeypatch):
    """Optuna waits for ever on one that leads nowhere."""
    monkeypatch.chdir(tmp_path)
    links, link = [], os.symlink

    def follow(target, path):
        links.append(Path(path).parent / target)
        link(target, path)

    monkeypatch.setattr(os, "symlink", follow)
    open_study("journal", Path("results/trials.journal"), "s")
    assert {path.resolve() for path in links} == {tmp_path / "results/trials.journal"}


def test_in_the_study_space_the_wrist_has_a_share_of_the_scale_and_nothing_is_guessed():
    study = optuna.create_study(sampler=optuna.samplers.RandomSampler(seed=0))
    space = search(space="study", action_scale=[1e-6, 1.0])
    chosen = np.array([choose(study.ask(), space, ROBOT).action_scale for _ in range(400)])
    base, share = chosen[:, 0], chosen[:, 1] / chosen[:, 0]
    for values in (base, share):
        assert 0 < values.min() < 0.02
        assert 0.98 < values.max() <= 1
        assert abs(values.mean() - 0.5) < 3 * np.sqrt(1 / 12 / 400)
    assert abs(np.corrcoef(base, share)[0, 1]) < 0.15


def test_a_study_in_the_study_space_has_no_first_guess_and_completes_every_trial(tmp_path):
    study = open_study("journal", tmp_path / "trials.journal", "s")
    asked = search(trials=2, space="study", action_scale=[1e-6, 1.0], prune=False, updates=1)
    work(study, PROBLEM, asked, TINY, seed=0)
    guess = first_guess(PROBLEM, asked)["action_scale_proximal"]
    assert study.trials[0].params["action_scale_proximal"] != pytest.approx(guess)
    assert count(study, TrialState.COMPLETE) == 2
    # as many updates as the section asks of a trial, not those of the training that follows
    assert study.trials[0].user_attrs["steps"] == 24 * TINY.environments
    found = best(study, ROBOT, 2)
    params = study.trials[found.number].params
    share = params["action_scale_distal_share"]
    assert found.choice.action_scale[1] == pytest.approx(params["action_scale_proximal"] * share)
    assert not found.choice.reward_weights


class ThreeGroups(type(ROBOT)):
    scale_groups = ("base", "elbow", "wrist")
    scale_group = np.array([0, 0, 1, 1, 2, 2, 2])


def test_robots_may_have_any_number_of_groups_that_share_a_scale():
    robot = ThreeGroups()
    trial = optuna.create_study().ask()
    choice = choose(trial, search(space="study", action_scale=[0.1, 1.0]), robot)
    assert len(choice.action_scale) == 3
    assert max(choice.action_scale) == choice.action_scale[0]
    scale = scale_per_joint((0.3, 0.2, 0.1), robot)
    assert scale.tolist() == [0.3, 0.3, 0.2, 0.2, 0.1, 0.1, 0.1]


@pytest.mark.parametrize("scales", [(0.1,), (0.1, 0.0), (0.1, np.inf), (0.1, 0.1, 0.1)], ids=str)
def test_action_scales_that_do_not_fit_a_robot_are_refused(scales):
    with pytest.raises(ConfigurationError, match="a number above 0 for each of proximal, distal"):
        scale_per_joint(scales, ROBOT)
