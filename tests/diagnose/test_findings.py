from types import SimpleNamespace

import numpy as np
import pytest

from t2l.diagnose.conditions import CONDITIONS
from t2l.diagnose.findings import Finding, findings, percent, round_thresholds

N = 2000


def _predictor(joints=("shoulder", "elbow"), kp=((10.0, 10.0), (40.0, 40.0))):
    njoint = len(joints)
    samples = SimpleNamespace(
        joint=np.tile(np.arange(njoint), N), recording=np.repeat([0, 1], N * njoint // 2)
    )
    return SimpleNamespace(
        joints=joints,
        samples=samples,
        recordings=[SimpleNamespace(kp=np.array(gains)) for gains in kp],
    )


def _features(predictor, **given):
    rng = np.random.default_rng(0)
    count = len(predictor.samples.joint)
    found = {name: rng.normal(size=count) for name in CONDITIONS}
    found["direction"] = np.sign(found["velocity"])
    return found | given


def test_the_error_of_a_slow_joint_is_found_and_said():
    predictor = _predictor()
    under = _features(predictor)
    slow = (np.abs(under["velocity"]) < 0.1) & (predictor.samples.joint == 1)
    residual = np.where(slow, 1.0, 0.1)
    first = findings(predictor, residual, under)[0]
    assert (first.joint, first.condition, first.where) == ("elbow", "velocity", "below 0.1 rad/s")
    share = slow.sum() / (residual**2).sum()
    assert first.share == pytest.approx(share)
    assert first.samples == pytest.approx(slow.mean())
    assert first.rmse_rad == pytest.approx(1.0)
    assert first.sentence == (
        f"{percent(share)} of the squared error is elbow below 0.1 rad/s, in "
        f"{percent(slow.mean())} of the samples"
    )


@pytest.mark.parametrize(
    ("where", "expected"),
    [
        (lambda f, p: f["torque"] > 0, "with positive commanded torque"),
        (lambda f, p: f["direction"] < 0, "moving in the negative direction"),
        (lambda f, p: p.samples.recording == 0, "at Kp 10"),
    ],
)
def test_signs_and_gains_are_found(where, expected):
    predictor = _predictor(joints=("hinge",), kp=((10.0,), (40.0,)))
    under = _features(predictor)
    residual = np.where(where(under, predictor), 1.0, 0.02)
    assert findings(predictor, residual, under)[0].where == expected


def test_a_joint_as_a_whole_is_found_where_no_condition_matters():
    predictor = _predictor()
    residual = np.where(predictor.samples.joint == 0, 1.0, 0.1)
    found = findings(predictor, residual, _features(predictor))
    assert [(f.joint, f.condition) for f in found] == [("shoulder", "")]
    assert "99 % of the squared error is shoulder, in 50 % of" in found[0].sentence


def test_near_duplicates_are_said_once():
    predictor = _predictor()
    under = _features(predictor)
    # the faster the command, the faster the joint
    under["command velocity"] = 1.01 * under["velocity"]
    under["acceleration"] = under["torque rate"] = under["velocity"]
    residual = np.where(np.abs(under["velocity"]) > 1.0, 1.0, 0.1)
    found = findings(predictor, residual, under)
    assert len({(f.joint, f.where) for f in found}) == len(found)
    fast = [f for f in found if "velocity" in f.condition or f.condition == "acceleration"]
    assert len([f for f in fast if f.joint == "elbow"]) == 1


def test_no_error_makes_no_findings():
    predictor = _predictor()
    residual = np.zeros(len(predictor.samples.joint))
    assert findings(predictor, residual, _features(predictor)) == []


def test_thresholds_have_one_digit():
    found = round_thresholds(np.abs(np.random.default_rng(1).normal(size=5000)) * 0.37)
    assert found == sorted(set(found))
    for value in found:
        mantissa = value / 10 ** np.floor(np.log10(value))
        assert min(abs(mantissa - m) for m in (1, 2, 5)) < 1e-9
    assert round_thresholds(np.zeros(10)) == []


def test_percent_reads_well():
    assert percent(0.623) == "62 %"
    assert percent(0.0042) == "0.4 %"
    assert Finding("j", "", "", 1.0, 1.0, 0.0).sentence.startswith("100 % of")
