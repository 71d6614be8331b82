"""Who waits is told for what, and Ctrl-C ends a run whatever it is doing."""

import signal
import subprocess
import sys
import time

import pytest

from t2l.effects.blame import blaming
from t2l.effects.registry import load
from t2l.errors import ConfigurationError, EffectError
from t2l.recordings import write_recording
from t2l.waiting import STATUS, told_if_slow
from tests.diagnose.made import pendulum, swings
from tests.effects.test_registry import RUBBER

# deaf to Ctrl-C, as a library that computes for long, and says that it has begun
DEAF = """
import time
from pathlib import Path

def compute():
    Path("begun").touch()
    while True:
        try:
            time.sleep(60)
        except BaseException:
            pass
"""
ON_IMPORT = f"{DEAF}\ncompute()\n"
# in a thread that an executor waits for
ON_INSTALL = DEAF + RUBBER.replace(
    "def install(self, loop, rows, joints, values):",
    "def install(self, loop, rows, joints, values):\n        compute()",
)
COMMANDS = {
    ON_IMPORT: ["effects", "--effects", "own.py"],
    ON_INSTALL: [
        "compare", "logs", "--model", "model.yaml", "--effects", "own.py", "--out", "out",
    ],
}  # fmt: skip
MODEL = """robot: pendulum.xml
effects: {rubber: {stiffness: {hinge: 0.1}}}
effect_files: [own.py]
"""


def test_who_waits_is_told_for_what_and_only_then(capfd):
    with told_if_slow("a quick file"):
        pass
    for _ in range(2):
        with told_if_slow("effect rubber (own.py)", after_s=0.01):
            time.sleep(0.2)
    said = capfd.readouterr().err
    assert said.count("waiting for effect rubber (own.py)") == 1
    assert "quick" not in said


@pytest.mark.parametrize("text", COMMANDS, ids=["import", "install"])
def test_ctrl_c_ends_what_does_not_listen(tmp_path, text):
    robot = pendulum(tmp_path)
    (tmp_path / "own.py").write_text(text)
    (tmp_path / "model.yaml").write_text(MODEL)
    write_recording(swings(robot, duration_s=0.3)[0], tmp_path / "logs/one")
    command = [sys.executable, "-m", "t2l", *COMMANDS[text]]
    with subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, text=True) as run:
        while not (tmp_path / "begun").exists():
            assert run.poll() is None, run.stderr.read()
            time.sleep(0.05)
        run.send_signal(signal.SIGINT)
        # far longer than it takes, and the file would go on for ever
        _, said = run.communicate(timeout=30)
    assert run.returncode == STATUS
    assert f"t2l {COMMANDS[text][0]}: interrupted; nothing is half-written" in said
    assert "Traceback" not in said


@pytest.mark.parametrize("raised", ["KeyboardInterrupt", "SystemExit(0)"])
def test_an_effect_that_ends_the_process_is_blamed(tmp_path, monkeypatch, raised):
    (tmp_path / "own.py").write_text(f"{RUBBER}\n    def ends(self):\n        raise {raised}\n")
    (tmp_path / "bad.py").write_text(f"raise {raised}")
    effect = load([tmp_path / "own.py"])["rubber"]
    # as where `interruptible` watches
    before = signal.signal(signal.SIGINT, lambda *_: None)
    try:
        with pytest.raises(EffectError, match=r"rubber .*own\.py, line \d+\): to end failed"), \
                blaming([effect], "to end"):  # fmt: skip
            effect.ends()
        with pytest.raises(ConfigurationError, match=r"bad\.py: cannot be imported"):
            load([tmp_path / "bad.py"])
    finally:
        signal.signal(signal.SIGINT, before)


def test_ctrl_c_of_a_person_is_not_blamed_on_an_effect(tmp_path):
    (tmp_path / "own.py").write_text(RUBBER)
    effect = load([tmp_path / "own.py"])["rubber"]
    with pytest.raises(KeyboardInterrupt), blaming([effect], "to end"):
        signal.raise_signal(signal.SIGINT)
