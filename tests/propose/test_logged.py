"""What follows a logged temperature or supply voltage is found, with its joint and its curve."""

from dataclasses import replace

import numpy as np
import pytest

from t2l.cli.main import main
from t2l.detective.data_split import split
from t2l.detective.explanation import proposed
from t2l.effects.law import COLUMNS, FRICTION, MOTOR, TORQUE, Curve, Law
from t2l.errors import EffectError
from t2l.identify.model import Model, read_model
from t2l.identify.prediction import Predictor
from t2l.propose.artefacts import proposed as names_in
from t2l.propose.artefacts import write_proposal
from t2l.propose.laws import ranges
from t2l.propose.proposal import LAW, error_of
from t2l.propose.wording import headline
from t2l.report import write_report
from tests.diagnose.made import measured, pendulum, recording, swing, two_pendulums

GAINS = ((5.0, 0.3, 0.7), (30.0, 1.0, 1.1), (12.0, 0.5, 0.9))


def warming(number, time):
    return 25.0 + 12.0 * number + 10.0 * time


def warming_more_slowly(number, time):
    return 32.0 + 10.0 * number + 8.0 * time


def at_three_temperatures(number, time):
    return 25.0 + 12.0 * number + 0 * time


def between_them(number, time):
    return 30.0 + 8.0 * number + 0 * time


def sagging(number, time):
    return 12.0 - number - 0.8 * time + 0.5 * np.sin(3 * time)


def sagging_evenly(number, time):
    return 11.5 - number - 0.6 * time


def machine(robot, column, values, truth, seed=0):
    """Recordings of two pendulums; the joints see the same values in opposite order."""
    made = []
    for number, (kp, kd, hz) in enumerate(GAINS):
        swings = swing(0.5, hz), swing(0.4, 0.7 * hz)

        def both(time, swings=swings):
            return np.stack([one(time) for one in swings], axis=1)

        one = recording(robot, both, f"kp{kp:g}_{seed}", kp, kd, 1.5, control_rate_hz=500.0)
        logged = values(number, one.time)
        one = replace(one, **{column: np.stack([logged, logged[::-1]], axis=1)})
        made.append(measured(one, None, 1e-4, seed + number, truth))
    return made


def learned(robot, column, values, unseen, truth):
    """The data and the one curve of a proposal that explains other recordings too."""
    unseen = machine(robot, column, unseen, truth, seed=9)
    data = split(robot, machine(robot, column, values, truth), unseen, threads=1)
    found = proposed(Model(robot), data)
    assert found.verdict == LAW
    assert found.report_rmse_rad < min(1.1e-4, 0.1 * found.report_baseline_rad)
    (one,) = found.learned
    return found, data, one


def slope(curve):
    return np.polyfit(curve.at, curve.torque, 1)[0]


@pytest.fixture(scope="module")
def weaker(tmp_path_factory):
    """A motor that weakens as it warms, in recordings of one temperature each."""
    robot = two_pendulums(tmp_path_factory.mktemp("robot"))
    values = {"factor": {"right": 1.0}, "per_kelvin": {"right": -4e-3}}
    truth = Model(robot, {"torque_constant_temperature": values})
    return learned(robot, "temperature", at_three_temperatures, between_them, truth)


def test_a_torque_constant_that_follows_temperature_is_a_share_of_the_motor_torque(weaker):
    found, _, one = weaker
    assert one.curve.law == Law(MOTOR, "right", "temperature", "right")
    assert slope(one.curve) == pytest.approx(-4e-3, rel=0.02)
    assert "a share of the motor torque on right that falls with its temperature" in headline(found)


def test_it_is_adopted_and_the_page_shows_it(weaker, tmp_path, monkeypatch):
    found, data, _ = weaker
    out = tmp_path / "out"
    write_proposal(found, out, [(data.fitted, data.fitted_mask)])
    monkeypatch.chdir(tmp_path)
    for name in names_in(out):
        main(["adopt", name, "--diagnosis", str(out), "--out", f"{name}.yaml"])
        error = error_of(read_model(tmp_path / f"{name}.yaml"), data.fitted)
        assert error == pytest.approx(1e-4, rel=0.1)
    assert "# of the motor torque" in (tmp_path / f"{names_in(out)[0]}.yaml").read_text()
    page = write_report(out).read_text()
    assert r"temperature [\u00b0C]" in page
    assert "share of the motor torque" in page


def test_dry_friction_that_follows_temperature_is_told_from_time(tmp_path):
    robot = two_pendulums(tmp_path)
    values = {"torque": {"right": 0.08}, "per_kelvin": {"right": -1.5e-3}}
    truth = Model(robot, {"friction_temperature": values})
    _, _, one = learned(robot, "temperature", warming, warming_more_slowly, truth)
    assert one.curve.law == Law(FRICTION, "right", "temperature", "right")
    assert slope(one.curve) == pytest.approx(-1.5e-3, rel=0.02)


def test_a_motor_that_follows_the_supply_voltage_is_found(tmp_path):
    robot, law = two_pendulums(tmp_path), Law(MOTOR, "right", "supply voltage", "right")
    truth = Model(robot, learned=(Curve(law, (8.0, 12.0), (-1 / 3, 0.0)),))
    _, _, one = learned(robot, "supply_voltage", sagging, sagging_evenly, truth)
    assert one.curve.law == law
    assert slope(one.curve) == pytest.approx(1 / 12, rel=0.02)


def test_a_bent_curve_over_temperature_is_recovered(tmp_path):
    robot, law = two_pendulums(tmp_path), Law(FRICTION, "right", "temperature", "right")
    at = np.linspace(20.0, 70.0, 60)
    level = 0.03 + 0.06 * np.exp(-(at - 20) / 10)
    truth = Model(robot, learned=(Curve(law, tuple(at.tolist()), tuple(level.tolist())),))
    _, _, one = learned(robot, "temperature", warming, warming, truth)
    assert one.curve.law == law
    np.testing.assert_allclose(one.curve.torque, np.interp(one.curve.at, at, level), atol=2e-3)


@pytest.mark.parametrize(
    ("column", "follows"), [("temperature", "temperature"), ("supply_voltage", "supply voltage")]
)
def test_a_law_follows_a_column_only_where_all_recordings_vary_it(tmp_path, column, follows):
    one = recording(pendulum(tmp_path), swing(), duration_s=0.3)
    has = replace(one, **{column: 20.0 + one.time[:, None]})
    still = replace(one, **{column: np.full_like(one.q, 20.0)})

    def kinds(recordings, others=()):
        predictor = Predictor(one.robot, recordings, threads=1)
        found = ranges(predictor, predictor.samples.q, 0 * predictor.samples.q, others)
        return {law.kind for law in found if law.follows == follows}

    assert kinds([has, has], [has]) == {TORQUE, FRICTION, MOTOR}
    assert not kinds([has, one])
    assert not kinds([has, has], [one])
    assert not kinds([still, still])


def test_recordings_that_report_need_the_column_too(tmp_path):
    robot = two_pendulums(tmp_path)
    truth = Model(robot, {"torque_offset": {"torque": {"right": 0.1}}})
    made = machine(robot, "temperature", warming, truth)
    bare = [replace(r, temperature=None) for r in machine(robot, "temperature", warming, truth, 9)]
    found = proposed(Model(robot), split(robot, made, bare, threads=1))
    assert not [c for c in found.ceilings if c.law.follows in COLUMNS]


def test_a_curve_without_its_column_is_told(tmp_path):
    robot = pendulum(tmp_path)
    law = Law(MOTOR, "hinge", "supply voltage", "hinge")
    model = Model(robot, learned=(Curve(law, (10.0, 12.0), (-0.1, 0.0)),))
    predictor = Predictor(robot, [recording(robot, swing())], threads=1)
    with pytest.raises(EffectError, match=r"learned_motor_hinge_supply_voltage.*supply_voltage"):
        error_of(model, predictor)
