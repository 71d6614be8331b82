import numpy as np
import pytest
from benchmarks import advice
from hypothesis import given
from hypothesis import strategies as st

from t2l.advise.attenuation import attenuation
from t2l.advise.cloning import amplifications, blended, difficulty, predicted_error
from t2l.advise.evidence import OURS, evidence, mean_of
from t2l.advise.loop import closed, sampled
from t2l.advise.machine import of_model
from t2l.identify.model import Model
from tests.advise.made import ARM, JOINTS

POSES = np.array([[0.4, 0.7], [0.1, -0.5]])


def machine(**effects):
    return of_model(Model(ARM, effects), JOINTS, POSES, 1000.0, True)


def gains(kp, kd):
    return np.array(kp)[:, None] * np.ones(2), np.array(kd)[:, None] * np.ones(2)


def test_much_damping_lets_through_what_the_theorem_says():
    found = amplifications(machine(), *gains([20.0], [8.0]), 50.0)[0, 0]
    # the links' own damping helps, by less than a hundredth
    assert found == pytest.approx(attenuation(20.0, 8.0, 0.02), rel=0.05)


def test_a_loop_that_does_not_settle_lets_through_all():
    late = machine(torque_delay={"delay": 0.02})
    found = amplifications(late, *gains([5.0, 5000.0], [0.5, 1.0]), 50.0)[0]
    assert np.isfinite(found[0]).all()
    assert np.isinf(found[1]).all()


def test_late_torques_let_more_through_as_drawn():
    """Monte Carlo of the whole loop with its delay, one joint."""
    late = machine(torque_delay={"delay": 0.0065}, actuator_bandwidth={"cutoff": {"elbow": 30.0}})
    kp, kd = gains([15.0], [0.5])
    found = amplifications(late, kp, kd, 50.0)[0, 0, 1]
    assert found > 1.2 * amplifications(machine(), kp, kd, 50.0)[0, 0, 1]
    plant = sampled(late.alone(1).mean(), 0.001)
    loop = closed(plant, kp[:, 1:], kd[:, 1:], late.signals.of(1))
    rng, n = np.random.default_rng(0), 300
    x, seen = np.zeros((n, loop.f.shape[1])), []
    for hold in range(300):
        error = rng.normal(size=(n, 1))
        for _ in range(20):
            x = x @ loop.f[0].T + error * loop.g[0, :, 0]
            if hold >= 50:
                seen.append(np.mean((x @ loop.h[0]) ** 2))
    assert found == pytest.approx(np.mean(seen), rel=0.05)


@given(kp=st.floats(1, 1000), kd=st.floats(0.01, 100))
def test_difficulty_is_the_error_of_the_command(kp, kd):
    left = np.random.default_rng(0).normal(size=(50, 2, 3))  # of (q, τ, q̇)
    c = np.einsum("tjc,tjd->jcd", left, left) / len(left)
    command = left[..., 0] + left[..., 1] / kp + kd / kp * left[..., 2]
    assert difficulty(c, *gains([kp], [kd]))[0] == pytest.approx(np.mean(command**2, axis=0))


def test_between_two_difficulties_lies_their_mean_of_logarithms():
    assert blended(np.array([4.0]), np.array([1.0]), 0.5) == pytest.approx([2.0])
    assert blended(np.array([4.0]), np.array([1.0]), 0.0) == pytest.approx([4.0])
    assert predicted_error(np.array([[0.25, 0.25]]), np.array([[4.0, 4.0]])) == pytest.approx([1.0])


@pytest.mark.slow
def test_the_kept_evidence_is_what_the_benchmark_measures():
    ours = {task: advice.of_ours(task, name) for task, name in advice.GRIDS.items()}
    others = {task: grid for task, grid in ours.items() if task != "dishwasher"}
    found = advice.measured("dishwasher", OURS, ours["dishwasher"], advice.chosen(others))
    (kept,) = [row for row in evidence().of(OURS) if row.grid == "dishwasher"]
    assert vars(kept) == {
        key: pytest.approx(value, abs=1e-3) if isinstance(value, float) else value
        for key, value in vars(found).items()
    }
    assert advice.chosen(ours) == (advice.BLEND, advice.CORRELATION)


def test_the_evidence_has_every_grid():
    kept = evidence()
    assert {row.grid for row in kept.of(OURS)} == set(advice.GRIDS)
    assert all(row.best >= row.advised for row in kept.grids)
    assert mean_of(kept.grids, "rho") == pytest.approx(np.mean([r.rho for r in kept.grids]))


def test_the_more_predicted_errors_differ_the_surer_is_their_order():
    kept = evidence().pairs
    assert kept[0].factor == 1
    assert [one.right for one in kept] == sorted(one.right for one in kept)
    assert evidence().right(1.0) == kept[0]
    assert evidence().right(100.0) == kept[-1]
