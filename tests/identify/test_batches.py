import numpy as np
import pytest

from t2l.effects.registry import builtin
from t2l.effects.term import Layout, Term
from t2l.identify import batches
from t2l.identify.batches import MAX_SIMULATIONS
from t2l.identify.prediction import Predictor, Request
from t2l.identify.scales import scales
from tests.diagnose.made import pendulum, recording, swing


def test_more_variants_than_one_batch_holds(tmp_path):
    made = recording(pendulum(tmp_path), swing(), duration_s=0.21, control_rate_hz=100.0)
    predictor = Predictor(made.robot, [made], threads=1)
    layout = Layout([Term(builtin()["torque_offset"], (0,))])
    u = np.linspace(-0.1, 0.1, MAX_SIMULATIONS + 7)[:, None]
    many, few = predictor.predict([Request(layout, u), Request(layout, u[-9:])])
    assert np.isfinite(many).all()
    np.testing.assert_array_equal(many[-9:], few)
    assert (np.diff(many[:, -1]) > 0).all()


@pytest.mark.parametrize("least_dofs_per_batch", [1, 1_000_000], ids=["batches", "threads"])
def test_threads_change_no_number(tmp_path, monkeypatch, least_dofs_per_batch):
    """Of loops whose physics steps differ, of models with more joints, side by side or shared."""
    monkeypatch.setattr(batches, "LEAST_DOFS_PER_BATCH", least_dofs_per_batch)
    monkeypatch.setattr(batches, "LEAST_STEPS_PER_THREAD", 1)
    robot, rates = pendulum(tmp_path), (1000.0, 300.0, 170.0)
    made = [
        recording(robot, swing(), f"{rate:g} Hz", duration_s=1.0, control_rate_hz=rate)
        for rate in rates
    ]
    requests = []
    one, two = Predictor(robot, made, threads=1), Predictor(robot, made, threads=2)
    for name in ("torque_offset", "joint_flexibility"):
        effect = builtin()[name]
        layout = Layout([Term(effect, (0,))])
        u = np.array([layout.encode({name: values}) for values in effect.starts(scales(one))])
        requests.append(Request(layout, np.concatenate([u, 1.1 * u, 0.9 * u])))
    expected = one.predict(requests, velocity=True)
    for _ in range(3):
        found = two.predict(requests, velocity=True)
        for one_thread, two_threads in zip(expected, found, strict=True):
            for values, other in zip(one_thread, two_threads, strict=True):
                np.testing.assert_array_equal(values, other)
