"""On which side of a measured torque the error lies."""

import dataclasses

import numpy as np
import pytest

from t2l.cli.main import main
from t2l.diagnose.measured_torque import torque_sides
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor, Request
from t2l.recordings import write_recording
from tests.diagnose.made import pendulum, recording, swing

KP, KD = 20.0, 0.8


def log(robot, effects=None, kp_factor=1.0, factor=1.0, hz=0.9, seed=0, noise=0.02):
    """A machine with effects whose torque was measured: kp_factor Kp, and all of it times factor.

    The torque has noise of a few hundredths of a N·m, positions of 0.1 mrad.
    """
    made = recording(robot, swing(0.5, hz), f"kp{hz:g}", KP, KD, 4.0, row_rate_hz=200.0)
    hidden = dict(effects or {})
    if kp_factor != 1:
        gains = {"kp_factor": {"hinge": kp_factor}, "kd_factor": {"hinge": 1.0}}
        hidden["controller_gains"] = gains
    if factor != 1:
        hidden["torque_constant"] = {"factor": {"hinge": factor}}
    layout, u = Model(robot, hidden).vector(made.joints)
    predictor = Predictor(robot, [made], threads=1)
    q, dq = (x[0][0][:, None] for x in predictor.predict([Request(layout, u[None])], velocity=True))
    rng = np.random.default_rng(seed)
    tau = factor * (kp_factor * KP * (made.q_des - q) - KD * dq)
    return dataclasses.replace(
        made, q=q + 1e-4 * rng.normal(size=q.shape), tau=tau + noise * rng.normal(size=q.shape)
    )


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    return pendulum(tmp_path_factory.mktemp("robot"))


def sides(made):
    (found,) = torque_sides(Predictor(made.robot, [made], threads=1))
    return found


def test_where_nothing_is_missing_both_sides_agree(robot):
    found = sides(log(robot))
    assert found.side == "neither"
    assert min(found.drive_share, found.machine_share) > 0.99
    assert np.isnan(found.kp_factor)


@pytest.mark.parametrize(
    "effects",
    [
        {"coulomb_friction": {"torque": {"hinge": 0.15}}},
        {"armature": {"inertia": {"hinge": 0.02}}},
    ],
)
def test_what_the_machine_lacks_is_the_machines(robot, effects):
    assert sides(log(robot, effects)).side == "machine"


def test_wrong_gains_are_the_drives_and_told(robot):
    found = sides(log(robot, kp_factor=0.7))
    assert found.side == "drive"
    assert found.kp_factor == pytest.approx(0.7, abs=0.01)
    assert found.kd_factor == pytest.approx(1.0, abs=0.05)
    weak = sides(log(robot, factor=0.8))
    assert weak.side == "drive"
    assert (weak.kp_factor, weak.kd_factor) == pytest.approx((0.8, 0.8), abs=0.05)


def test_both_may_be_wrong(robot):
    friction = {"coulomb_friction": {"torque": {"hinge": 0.15}}}
    assert sides(log(robot, friction, factor=0.9)).side == "both"


def test_a_log_without_torque_says_nothing(robot):
    made = dataclasses.replace(log(robot), tau=None)
    assert torque_sides(Predictor(robot, [made], threads=1)) == []


def test_compare_says_it(robot, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_recording(log(robot, kp_factor=0.7), tmp_path / "logs/swing")
    main(["compare", "logs", "--out", "out"])
    said = capsys.readouterr().out
    assert "the error lies in the drive" in said
    assert "real over logged gains: Kp 0.70 and Kd" in said
