"""What changes over a session is found by the clock that its recordings share."""

from dataclasses import replace

import numpy as np
import pytest

from t2l.effects.law import FRICTION, MOTOR, PHASE, SESSION, TORQUE, Curve, Law
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor
from t2l.propose.laws import ranges
from t2l.propose.proposal import LAW
from t2l.propose.wording import headline
from tests.diagnose.made import measured, pendulum, predict, recording, swing
from tests.export.test_export import exported
from tests.propose.made import learn

DURATION_S = 1.5
KINDS = {
    "friction_drift": ({"at_start": 0.1, "at_end": 0.02}, FRICTION, "dry friction on hinge"),
    "torque_constant_drift": (
        {"at_start": 1.0, "at_end": 0.8},
        MOTOR,
        "a share of the motor torque on hinge",
    ),
}


def session(robot, truth=None, numbers=range(6), begin_s=0.0, gap_s=0.5):
    """Recordings one after the other, after breaks."""
    made = []
    for number in numbers:
        one = recording(
            robot, swing(0.5, 0.7 + 0.1 * number), f"r{number}", (5.0, 12.0, 30.0)[number % 3], 0.5,
            DURATION_S, control_rate_hz=500.0,
        )  # fmt: skip
        late = begin_s + number * (DURATION_S + gap_s)
        made.append(measured(replace(one, time=one.time + late), None, 1e-4, number, truth))
    return made


@pytest.mark.parametrize("name", KINDS)
def test_a_drift_over_a_session_is_told_from_time_within_a_recording(tmp_path, name):
    ends, kind, said = KINDS[name]
    robot = pendulum(tmp_path)
    values = {key: {"hinge": value} for key, value in ends.items()} | {"time_constant": 6.0}
    made = session(robot, Model(robot, {name: values}), range(9))
    unseen = made[1::3]
    found = learn(robot, [r for r in made if r not in unseen], unseen)
    assert found.verdict == LAW
    laws = {one.curve.law for one in found.learned}
    assert Law(kind, "hinge", SESSION, "hinge") in laws
    assert not {law.follows for law in laws} & {"time", PHASE}
    assert f"{said} that falls with the time of the session" in headline(found)
    assert found.report_rmse_rad < 0.1 * found.report_baseline_rad


@pytest.mark.parametrize("begin_s", [0.0, 1.7e9])
def test_the_clock_may_begin_anywhere(tmp_path, begin_s):
    robot = pendulum(tmp_path)
    law = Law(FRICTION, "hinge", SESSION, "hinge")
    curve = Curve(law, (begin_s, begin_s + 20.0), (0.1, 0.0))
    (last,) = session(robot, numbers=[5], begin_s=begin_s)
    constant = Law(FRICTION, "hinge", "constant", "hinge")
    middle_s = last.time.mean() - begin_s
    alike = Curve(constant, (0.0, 1.0), (0.1 - middle_s * 0.005,) * 2)
    by_clock, level = (predict(last, model=Model(robot, learned=(c,))) for c in (curve, alike))
    moved = np.abs(level - predict(last)).max()
    assert np.abs(by_clock - level).max() < 0.1 * moved


@pytest.mark.parametrize("gap_s", [-DURATION_S, -0.5 * DURATION_S])
def test_recordings_whose_clocks_overlap_are_no_session(tmp_path, gap_s):
    robot = pendulum(tmp_path)

    def followed(gap_s):
        predictor = Predictor(robot, session(robot, gap_s=gap_s), threads=1)
        still = np.zeros(len(predictor.samples))
        return {law.follows for law in ranges(predictor, still, still)}

    assert SESSION in followed(0.5)
    assert SESSION not in followed(gap_s)


def test_a_simulator_has_no_session(tmp_path):
    robot = pendulum(tmp_path)
    learned = (Curve(Law(FRICTION, "hinge", SESSION, "hinge"), (0.0, 9.0), (0.1, 0.0)),)
    content, _, _ = exported(tmp_path / "out", robot, {}, learned=learned)
    assert "session time" in str(content["not_carried"])


@pytest.mark.parametrize("begin_s", [0.0, 1.7e9])
def test_a_torque_that_repeats_by_the_clock_is_found_with_its_period(tmp_path, begin_s):
    """Between the recordings the phase goes on, so that none begins as another does."""
    robot, period_s = pendulum(tmp_path), 1.3
    angle = np.linspace(0, 2 * np.pi, 61)
    shape = 0.03 * np.sin(angle) + 0.01 * np.sin(2 * angle)
    at = begin_s + angle / (2 * np.pi) * period_s
    law = Law(TORQUE, "hinge", PHASE, "hinge")
    truth = Model(robot, learned=(Curve(law, tuple(at), tuple(shape)),))
    made = session(robot, truth, range(6), begin_s)
    found = learn(robot, made[:4], made[4:])
    assert [one.curve.law for one in found.learned] == [law]
    (one,) = found.learned
    assert one.curve.at[-1] - one.curve.at[0] == pytest.approx(period_s, rel=0.01)
    assert "a torque on hinge that repeats by the clock every 1.3 s" in headline(found)
    assert found.report_rmse_rad < 2 * found.noise_floor_rad
