import pytest

from t2l.cli.estimate import duration, likely_s, say_how_long
from t2l.identify.model import Model
from tests.diagnose.made import pendulum, swings


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    return pendulum(tmp_path_factory.mktemp("robot"))


@pytest.mark.parametrize(
    ("low", "high", "words"),
    [(24.2, 71.0, "20 to 70 s"), (180.0, 480.0, "3 to 8 minutes"), (3.0, 4.0, "3 to 4 s"),
     (8000.0, 22000.0, "2 to 6 h"), (0.1, 0.2, "1 to 2 s"), (50.0, 250.0, "1 to 4 minutes")],
)  # fmt: skip
def test_times_are_in_the_unit_of_the_longer_one(low, high, words):
    assert duration(low, high) == words


def test_slower_simulations_and_more_effects_take_longer():
    for command in ("diagnose", "explain", "propose"):
        low, high = likely_s(command, 0.01, 30)
        assert 0 < low < high
        assert likely_s(command, 0.02, 30) > (low, high)
        assert likely_s(command, 0.01, 40) > (low, high)
        assert likely_s(command, 0.01, 30, 2) > (low, high)
    assert likely_s("compare", 0.01, 30) == likely_s("compare", 0.01, 40)


def test_it_is_said_with_the_cores_of_the_machine(robot, capsys):
    say_how_long("explain", Model(robot), swings(robot, duration_s=1.0), threads=1)
    said = capsys.readouterr().out
    assert said.startswith("This takes about ")
    assert said.endswith("on this machine (1 core).\n")


def test_a_limit_of_time_is_said_too(robot, capsys):
    recordings = swings(robot, duration_s=1.0)
    say_how_long("explain", Model(robot), recordings, threads=1, at_most_s=30)
    assert capsys.readouterr().out.endswith("(1 core), the search no longer than 30 s.\n")
