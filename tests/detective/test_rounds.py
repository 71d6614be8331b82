"""A search that is interrupted, goes on, or runs out of time, and what stands in its folder."""

import json
import re
import signal
import subprocess
import sys
import time
from dataclasses import replace

import pytest

from t2l.cli.main import main
from t2l.detective import search as searching
from t2l.detective.certainty import chosen_shares
from t2l.detective.data_split import split
from t2l.detective.explanation import explained, in_words
from t2l.detective.search import search
from t2l.diagnose.explanation import Explanation, Step, as_json
from t2l.diagnose.ranking import MISSING
from t2l.effects.registry import builtin
from t2l.identify.model import Model, read_model
from t2l.recordings.log import write_recording
from t2l.waiting import STATUS
from tests.detective.test_search import HIDDEN, recorded
from tests.diagnose.made import pendulum

NAMES = set(HIDDEN)
# what else is tried, so that a search takes a second
TRIED = {*NAMES, "armature", "viscous_friction", "torque_offset", "payload"}
WITHOUT = tuple(sorted(set(builtin()) - TRIED))


class StoppedError(Exception):
    pass


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    return pendulum(tmp_path_factory.mktemp("robot"))


@pytest.fixture
def one_at_a_time(monkeypatch):
    """Sets of one effect, so that two that are hidden take two rounds."""
    monkeypatch.setattr("t2l.detective.screen.MOST", 1)
    monkeypatch.setattr("t2l.detective.forward.MOST", 1)


@pytest.fixture(scope="module")
def made(robot):
    return recorded(robot, HIDDEN)


def told(robot, recordings, folder=None, **others):
    data = split(robot, recordings, threads=1)
    return explained(Model(robot, without=WITHOUT), data, folder=folder, **others)


def interrupted(robot, recordings, folder):
    def stop():
        raise StoppedError

    with pytest.raises(StoppedError):
        told(robot, recordings, folder, written=stop)


def content(folder):
    return json.loads((folder / "explanation.json").read_text())


@pytest.mark.usefixtures("one_at_a_time")
def test_what_stands_after_a_round_is_where_the_same_search_goes_on(robot, made, tmp_path):
    straight = told(robot, made)
    assert [len(step.effects) for step in straight.steps] == [0, 1, 1]
    interrupted(robot, made, tmp_path)
    so_far = content(tmp_path)
    assert so_far["final"] is False
    assert [step["effects"] for step in so_far["steps"]] == [[], list(straight.steps[1].effects)]
    assert so_far["sentence"].startswith("The model lacks ")
    assert so_far["sentence"].endswith("The search goes on.")
    first = read_model(tmp_path / "steps/1/model.yaml")
    assert set(first.effects) == set(straight.steps[1].effects)
    assert read_model(tmp_path / "model.yaml") == first
    assert read_model(tmp_path / "steps/0/model.yaml").effects == {}

    looked = []
    again = told(robot, made, tmp_path, progress=lambda what, fraction: looked.append(what))
    assert as_json(again) == as_json(straight)
    assert again.model == straight.model
    assert not any(what.startswith("round 1") for what in looked)
    assert any(what.startswith("round 2: fitting") for what in looked)
    assert content(tmp_path)["final"] is True
    assert set(read_model(tmp_path / "steps/2/model.yaml").effects) == NAMES


@pytest.mark.usefixtures("one_at_a_time")
def test_other_recordings_or_a_broken_file_begin_anew(robot, made, tmp_path):
    interrupted(robot, made, tmp_path)
    (tmp_path / "steps/7").mkdir()
    kept = tmp_path / "steps/fitted.npz"
    whole = kept.read_bytes()
    rounds = []

    def looked(what, fraction):
        rounds.append(what.partition(":")[0])
        raise StoppedError

    for recordings, left in ((recorded(robot, HIDDEN)[:4], whole), (made, whole[:-100])):
        kept.write_bytes(left)
        changed = recordings[:1] + recordings[2:] if left is whole else recordings
        with pytest.raises(StoppedError):
            told(robot, changed, tmp_path, progress=looked)
    assert rounds == ["round 1", "round 1"]
    interrupted(robot, made, tmp_path)
    assert sorted(path.name for path in (tmp_path / "steps").iterdir()) == ["0", "1", "fitted.npz"]


@pytest.mark.usefixtures("one_at_a_time")
def test_time_that_is_over_ends_with_what_was_adopted_or_is_likely(robot, made):
    asked = []

    def over():
        asked.append(None)
        return len(asked) > after

    after = 0
    nothing = told(robot, made, spent=over)
    assert nothing.verdict == MISSING
    assert nothing.model.effects == {}
    assert "stopped by --time" in nothing.sentence
    assert "likely" not in nothing.sentence

    asked.clear()
    after = 1
    likely = told(robot, made, spent=over)
    assert likely.model.effects == {}
    assert likely.stopped_after_s > 0
    assert re.search(r"most likely (command delay|Coulomb friction)", likely.sentence)

    asked.clear()
    after = 3
    one = told(robot, made, spent=over)
    assert len(one.steps) == 2
    assert one.sentence.startswith("The model lacks ")
    assert "stopped by --time" in one.sentence
    assert "Nothing more is missing" not in one.sentence


def test_how_sure_a_step_is_stands_beside_it():
    one = Step(("a",), 1.0, 1.0, 1.0, titles=("friction",), chosen_shares=(0.83,))
    two = replace(one, titles=("friction", "delay"), chosen_shares=(0.83, 0.4))
    steps = [Step((), 2.0, 2.0, 2.0), one, two, replace(one, chosen_shares=(0.4,))]
    first, *rest, _ = in_words(Explanation(steps, MISSING, 0.1, "The end.", None))
    assert "chosen" not in first
    assert [line.partition(", chosen in ")[2] for line in rest] == [
        "83 % of resamples",
        "83 and 40 % of resamples, uncertain: delay",
        "40 % of resamples, uncertain",
    ]


def test_shares_of_resamples_are_those_of_what_stands_out(robot, made):
    kept = []

    def shares_of(sets, folds, added, **others):
        kept.append((sets, folds, added))
        return chosen_shares(sets, folds, added, **others)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(searching, "chosen_shares", shares_of)
        # without what may take the place of friction in some resamples
        without = (*WITHOUT, "armature", "viscous_friction")
        data, names_alone = split(robot, made, threads=1), searching.Offered(curves=False)
        found = search(Model(robot, without=without), data, offered=names_alone)
    (sets, folds, added), *_ = kept
    shares = found.rounds[0].shares
    assert set(shares) == NAMES
    assert min(shares.values()) >= 0.5
    assert chosen_shares(sets, folds, added | {"payload": (0,)})["payload"] <= 0.1
    # without the set that has them nothing can choose them
    assert set(chosen_shares(sets[:1], folds, added).values()) == {0.0}


@pytest.fixture
def at_home(robot, made, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for recording in made:
        write_recording(recording, tmp_path / "logs" / f"{recording.name}_{recording.duration_s:g}")
    return tmp_path


LEFT_OUT = [part for name in WITHOUT for part in ("--without", name)]
EXPLAIN = """
from t2l.detective import screen
screen.MOST = 1
from t2l.cli.main import main
main(["explain", "logs", "--out", "{out}", *{without}])
"""


def test_ctrl_c_leaves_whole_files_and_the_same_command_goes_on(at_home):
    def command(out):
        return [sys.executable, "-c", EXPLAIN.format(out=out, without=LEFT_OUT)]

    out = at_home / "out"
    with subprocess.Popen(command("out"), stderr=subprocess.PIPE, text=True) as run:
        while not (out / "report.html").exists():
            assert run.poll() is None, run.stderr.read()
            time.sleep(0.01)
        run.send_signal(signal.SIGINT)
        _, said = run.communicate(timeout=60)
    assert run.returncode == STATUS
    assert "interrupted" in said
    so_far = content(out)
    assert so_far["final"] is False
    assert "The search goes on." in (out / "report.html").read_text()
    for name in ("out", "straight"):
        done = subprocess.run(command(name), capture_output=True, text=True, check=True)
        assert ("Going on after step 1" in done.stdout) == (name == "out")
    assert content(out) == content(at_home / "straight")
    assert "The search goes on." not in (out / "report.html").read_text()


@pytest.mark.parametrize("given", ["0", "-3", "nan", "inf", "soon", "1e9"])
def test_a_time_that_is_none_is_refused(at_home, given):
    with pytest.raises(SystemExit) as caught:
        main(["explain", "logs", f"--time={given}", "--out", "out"])
    assert re.search(r"--time: found .*; allowed: seconds, above 0 and up to", caught.value.code)
    assert not (at_home / "out").exists()


def test_a_short_time_ends_with_files_and_a_page(at_home, capsys):
    main(["explain", "logs", "--time", "0.01", "--out", "out"])
    said = capsys.readouterr().out
    assert re.search(r"This takes about .*, the search no longer than 0.01 s\.", said)
    assert "stopped by --time" in said
    found = content(at_home / "out")
    assert found["final"] is True
    assert found["verdict"] == MISSING
    assert "stopped by --time" in (at_home / "out/report.html").read_text()
