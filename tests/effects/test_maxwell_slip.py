"""Elements that stretch and slip: what holds, what is lost, and what they are in their limits."""

from itertools import pairwise

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from t2l.effects.elements import stretch, stretched, way_at_start
from t2l.effects.maxwell_slip_friction import strongest_elements
from t2l.errors import ConfigurationError
from t2l.identify.model import read_model
from tests.diagnose.made import WEIGHT, hold, pendulum, predict, recording, spinner, swing

AWAY = 0.5  # rad, from where the pendulum hangs
NEEDED = WEIGHT * np.sin(AWAY)  # N·m, that holds it there


def on_the_hinge(torque, radii):
    """The effect of three elements, on the joint of a pendulum."""
    values = {}
    for k, (most, radius) in enumerate(zip(torque, radii, strict=True), start=1):
        values |= {f"torque_{k}": {"hinge": most}, f"radius_{k}": {"hinge": radius}}
    return {"maxwell_slip_friction": values}


@st.composite
def elements(draw):
    """Torques, N·m, and radii, rad, of some elements."""
    radii = draw(st.lists(st.floats(1e-3, 0.5), min_size=1, max_size=6))
    torque = draw(st.lists(st.floats(0.0, 5.0), min_size=len(radii), max_size=len(radii)))
    return np.array(torque), np.array(radii)


@given(elements(), st.floats(-20.0, 20.0))
def test_at_rest_they_hold_what_is_missing_as_far_as_they_can(of, missing):
    torque, radii = of
    still = np.array(0.0)
    z = stretched(way_at_start(np.array(missing), still, torque, radii), still, radii)
    most = torque.sum()
    assert np.sum(torque * z / radii) == pytest.approx(np.clip(missing, -most, most), abs=1e-9)
    # as if it came there from where nothing was stretched: those that do not slip are alike
    np.testing.assert_allclose(np.abs(z), np.minimum(np.abs(z).max(), radii), atol=1e-12)


@given(elements(), st.sampled_from([-1.0, 1.0]), st.floats(-1.0, 1.0))
def test_in_motion_they_are_where_a_motion_from_the_other_end_takes_them(of, side, part):
    torque, radii = of
    dq, most = np.array(side), radii.max()
    way = way_at_start(np.array(0.3), dq, torque, radii)
    np.testing.assert_allclose(stretched(way, dq, radii), side * radii)
    # a motion from one end, as far as the largest radius is twice
    way = part * most
    state = {"q": np.array(0.0), "z": -side * radii}
    moved, _ = stretch(np.array(way + side * most), dq, state, radii, 0.0)
    np.testing.assert_allclose(stretched(np.array(way), dq, radii), moved, atol=1e-12)


@given(elements(), st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=30))
def test_a_cycle_never_gives_energy(of, turns):
    """Whatever the way, once all that was stretched at first is so again."""
    torque, radii = of
    way = np.concatenate([[-3.0], turns, [-3.0]])
    # small steps, of which the mean of two torques is the mean
    q = np.concatenate([np.linspace(a, b, 200) for a, b in pairwise(way)])
    state = {"q": q[0], "z": -radii}
    z, _ = stretch(q, np.zeros_like(q), state, radii, 0.0)
    force = (torque * z / radii).sum(axis=-1)
    np.testing.assert_allclose(z[0], z[-1])
    lost = np.sum((force[1:] + force[:-1]) / 2 * np.diff(q))
    assert lost >= -1e-9 * max(torque.sum(), 1.0)
    # there and back, each element slips by what it did not stretch
    if len(turns) == 1:
        span = turns[0] + 3.0
        exact = np.sum(4 * torque * np.maximum(span / 2 - radii, 0.0))
        step = span / 199
        assert lost == pytest.approx(exact, abs=2 * step * torque.sum() + 1e-9)


def test_rows_are_stretched_each_by_its_own():
    rng = np.random.default_rng(0)
    missing, dq = rng.normal(size=20), np.repeat([0.0, 1.0], 10)
    torque, radii = rng.uniform(0, 1, (20, 3)), rng.uniform(0.01, 1, (20, 3))
    way = way_at_start(missing, dq, torque, radii)
    for i, one in enumerate(stretched(way, dq, radii)):
        alone = way_at_start(missing[i], dq[i], torque[i], radii[i])
        np.testing.assert_allclose(one, stretched(alone, dq[i], radii[i]))


def test_the_strongest_are_found_among_others():
    rng = np.random.default_rng(0)
    columns = rng.normal(size=(500, 12))
    levels, chosen = strongest_elements(columns, columns @ np.eye(12)[[2, 7]].T @ [0.5, 2.0])
    assert dict(zip(chosen.tolist(), levels, strict=True)) | {2: 0.5, 7: 2.0} == pytest.approx(
        {2: 0.5, 7: 2.0} | {int(i): 0.0 for i in chosen if i not in (2, 7)}, abs=1e-6
    )
    # what pushes with the motion is no friction
    levels, _ = strongest_elements(columns, -columns[:, 3])
    assert (levels >= 0).all()


@pytest.mark.parametrize(
    ("parameter", "value", "said"),
    [
        ("torque_1", -1.0, r"torque_1 = -1.0 N·m; allowed 0 or more"),
        ("radius_2", 0.0, r"radius_2 = 0.0 rad; allowed more than 0"),
    ],
)
def test_a_model_file_with_what_no_element_can_be_is_told(tmp_path, parameter, value, said):
    effects = on_the_hinge((0.1, 0.1, 0.1), (0.1, 0.2, 0.3))
    effects["maxwell_slip_friction"][parameter] = {"hinge": value}
    pendulum(tmp_path)
    path = tmp_path / "model.yaml"
    path.write_text(yaml.safe_dump({"robot": "pendulum.xml", "effects": effects}))
    with pytest.raises(ConfigurationError, match=said):
        read_model(path)


def held(tmp_path, share):
    """How far a pendulum goes in a second that elements hold with a share of what it needs."""
    model = on_the_hinge(share * NEEDED * np.array([0.7, 0.2, 0.1]), (0.05, 0.2, 0.3))
    # commanded to be where it is, so that the motor gives nothing
    q = predict(recording(pendulum(tmp_path), hold(AWAY)), model)
    return np.abs(q - AWAY).max()


def test_what_holds_a_joint_at_rest_keeps_it_there(tmp_path):
    assert held(tmp_path, 1.5) < 1e-9
    # the motor alone lets it sag
    assert held(tmp_path, 0.0) > 1e-2


def test_what_is_too_weak_to_hold_it_lets_it_go(tmp_path):
    assert 1e-3 < held(tmp_path, 0.5) < held(tmp_path, 0.0)


def test_small_radii_are_coulomb_friction(tmp_path):
    made = recording(pendulum(tmp_path), swing(), duration_s=1.5)
    dry = predict(made, {"coulomb_friction": {"torque": {"hinge": 0.1}}})
    apart = [
        np.abs(predict(made, on_the_hinge((0.05, 0.03, 0.02), (r, r, r))) - dry).max()
        for r in (1e-2, 1e-3, 1e-4)
    ]
    assert apart[0] > 3 * apart[1] > 6 * apart[2]
    assert apart[2] < 0.1 * np.abs(dry - predict(made)).max()


def test_one_that_never_slips_is_a_spring_from_where_it_began(tmp_path):
    made = recording(spinner(tmp_path), swing(), kp=20.0, kd=0.5)
    spring = {"stiffness": {"hinge": 0.4}, "rest": {"hinge": float(made.q_des[0, 0])}}
    expected = predict(made, {"parallel_spring": spring})
    q = predict(made, on_the_hinge((2.0, 0.0, 0.0), (5.0, 1.0, 1.0)))
    assert np.abs(expected - predict(made)).max() > 3e-3
    np.testing.assert_allclose(q, expected, atol=3e-5)
