"""Setups and options of `t2l plan`."""

import shutil

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from t2l.cli.main import main
from t2l.design.experiment import Wanted, check_wanted
from t2l.hardware import BACKENDS
from t2l.hardware.plan import plan_model, read_setup
from tests.design.made import configuration
from tests.fuzz.generate import as_bytes, spoilt
from tests.fuzz.harness import check
from tests.fuzz.test_recordings import QUIET

PLAN_FILE = plan_model(BACKENDS.find("virtual"))
# a motion each of the shortest length: a run takes half a second and its figures another two
TIMES = ["--motion-s", "1", "--total-s", "3"]
NUMBERS = [
    "nan",
    "inf",
    "-inf",
    "0",
    "-1",
    "1e-9",
    "1e300",
    "1e9",
    "x",
    "",
    "1,2",
    "0x10",
    "9" * 400,
]
SOUND = {
    "--total-s": ["3", "4.5", "60"], "--motion-s": ["1", "1.5"], "--most-rad": ["0.1", "9"],
    "--noise-mrad": ["0.01", "5"], "--tell": ["coulomb_friction", "viscous_friction,armature"],
    "--workspace": ["-1,-1,0,1,1,2", "-0.1,-1,0,0.1,1,2"],
}  # fmt: skip
FOREIGN = {
    "--tell": ["", ",", "coulomb", "gravity", "armature,armature", "x" * 5000, "\0"],
    "--workspace": [
        "nan,-1,0,1,1,2", "-1,-1,0,1,1", "1,1,2,-1,-1,0", "inf,inf,inf,inf,inf,inf", "a,b,c,d,e,f",
        "", "5,5,5,6,6,6", "0,0,0,0,0,0", "-inf,-1,0,1,1,2", "1," * 3000,
    ],
}  # fmt: skip


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    home = tmp_path_factory.mktemp("home")
    configuration(home)
    return home


@st.composite
def options(draw) -> list[str]:
    """Up to three options, each with a value that is sound, or not."""
    words = []
    for name in draw(st.lists(st.sampled_from(sorted(SOUND)), max_size=3, unique=True)):
        wrong = FOREIGN.get(name, NUMBERS)
        words.append(f"{name}={draw(st.sampled_from(draw(st.sampled_from([SOUND[name], wrong]))))}")
    return words


def planned(home, *words):
    """How `t2l plan` ended; what it wrote is a plan that `t2l record` takes."""
    line = ["plan", *words, "--out", "out"]
    message = check(lambda: main(line), home, home / "out")
    written = home / "out/plan.yaml"
    assert written.exists() == (message is None)
    if message is None:
        record = ["record", str(written), "--out", "logs", "--check"]
        assert check(lambda: main(record), home, home / "logs") is None
    shutil.rmtree(home / "out", ignore_errors=True)
    return message


@settings(max_examples=8, **QUIET)
@given(words=options())
def test_options(home, words):
    tell = [] if any(word.startswith("--tell") for word in words) else ["--tell=coulomb_friction"]
    message = planned(home, "setup.yaml", *TIMES, *tell, *words)
    given = {name for name in SOUND if any(word.startswith(name) for word in words)}
    # what is wrong is named, and not something else
    assert message is None or any(name in message for name in given), message


@settings(max_examples=60, **QUIET)
@given(data=st.data())
def test_setups(home, data):
    sound = yaml.safe_load((home / "setup.yaml").read_text())
    document = data.draw(spoilt(sound, PLAN_FILE))
    (home / "bad.yaml").write_bytes(data.draw(as_bytes(document)))

    def read():
        setup = read_setup(home / "bad.yaml")
        check_wanted(setup, Wanted([], 60.0, 6.0, 0.5, 1e-4))

    # the whole command takes seconds; what it reads it reads first
    check(read, home, home / "out", ("bad.yaml", "--motion-s"))


@settings(max_examples=3, **QUIET)
@given(data=st.data())
def test_whole_commands(home, data):
    sound = yaml.safe_load((home / "setup.yaml").read_text())
    document = data.draw(spoilt(sound, PLAN_FILE))
    (home / "bad.yaml").write_bytes(data.draw(as_bytes(document)))
    planned(home, "bad.yaml", *TIMES, "--tell", "coulomb_friction")


def test_the_sound_ones_run(home):
    assert planned(home, "setup.yaml", *TIMES, "--tell=coulomb_friction") is None
