"""Bounds, sizes and first guesses of effects follow the robot; every number here is exact."""

import re

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from t2l.effects.effect import Effect, Parameter, within
from t2l.effects.registry import builtin
from t2l.effects.term import Layout, Term
from t2l.errors import ConfigurationError
from t2l.identify.model import Model, from_vector
from t2l.identify.prediction import Predictor
from t2l.identify.scales import sized
from tests.diagnose.made import pendulum, swings
from tests.effects.made import made_sizes

JOINTS = ("a", "b", "c")
NAMES = sorted(builtin())


def power(unit):
    """Of a robot's mass in a unit, positions and times left alone."""
    if unit.startswith("1/("):
        return -power(unit[3:])
    return int(bool(re.match(r"N|kg", unit)))


def bounded(name, sizes):
    return within(builtin()[name], sizes.plant, sizes.joints, sizes)


def layout_of(effect):
    return Layout([Term(effect, tuple(range(len(JOINTS))))])


@pytest.mark.parametrize("name", NAMES)
@settings(deadline=None, max_examples=5)
@given(factor=st.floats(-3, 3).map(lambda exponent: 10.0**exponent))
def test_a_robot_of_other_mass_has_the_same_ranges_in_its_own_sizes(name, factor):
    one, other = made_sizes(JOINTS), made_sizes(JOINTS, factor)
    for a, b in zip(*(layout_of(bounded(name, s)).slots for s in (one, other)), strict=True):
        times = factor ** power(a.parameter.unit)
        for key in ("lower", "upper", "size"):
            assert getattr(b, key) == pytest.approx(times * getattr(a, key), rel=1e-9), (a.key, key)
    starts = (builtin()[name].starts(sizes) for sizes in (one, other))
    for a, b in zip(*starts, strict=True):
        for parameter in builtin()[name].parameters:
            times = factor ** power(parameter.unit)
            expected = times * np.asarray(a[parameter.name])
            np.testing.assert_allclose(b[parameter.name], expected, rtol=1e-9, atol=1e-12 * times)


def test_no_torque_inertia_or_mass_has_a_range_in_units():
    absolute = {
        (name, p.name)
        for name, effect in builtin().items()
        for p in effect.parameters
        if power(p.unit) and not p.scale
    }
    assert absolute == set()


@pytest.mark.parametrize("name", NAMES)
def test_first_guesses_lie_in_the_range(name):
    sizes = made_sizes(JOINTS)
    layout = layout_of(bounded(name, sizes))
    for start in builtin()[name].starts(sizes):
        for slot in layout.slots:
            value = np.broadcast_to(start[slot.parameter.name], len(JOINTS))[slot.joint or 0]
            # of a load whose arm is a guess, the least masses lie in it
            if (name, slot.parameter.name) != ("payload", "mass"):
                assert slot.lower <= value <= slot.upper, slot.key


def test_what_is_added_is_no_less_than_all_that_the_joint_has():
    sizes = made_sizes(JOINTS)
    for name, own in (("armature", 0.1), ("viscous_friction", 0.2), ("coulomb_friction", 0.3)):
        assert [s.lower for s in layout_of(bounded(name, sizes)).slots] == [-own] * len(JOINTS)


def test_a_number_of_the_robot_has_the_range_of_the_joint_that_moves_most():
    sizes = made_sizes(JOINTS)
    (mass, *_) = layout_of(bounded("payload", sizes)).slots
    assert mass.upper == 10 * sizes.mass.max()


def test_without_recordings_bounds_are_what_is_possible():
    for name, lower in (("torque_offset", -np.inf), ("torque_dead_zone", 0.0)):
        layout = layout_of(builtin()[name])
        assert (layout.lower == lower).all()
        assert (layout.upper == np.inf).all()
    limit = layout_of(builtin()["torque_saturation"])
    assert (limit.lower == -np.inf).all()  # of the logarithm


def test_a_stated_value_far_outside_is_kept_and_may_be_fitted(tmp_path):
    robot = pendulum(tmp_path)
    predictor = Predictor(robot, swings(robot, duration_s=0.5), threads=1)
    stated = {"torque_offset": {"torque": {"hinge": -9e3}}, "payload": {"mass": 7e3}}
    stated["payload"] |= dict.fromkeys(("com_x", "com_y", "com_z"), 0.0)
    for model in (Model(robot, stated), sized(Model(robot, stated), predictor)):
        layout, u = model.vector(("hinge",))
        assert from_vector(model, layout, u, ("hinge",)).effects == stated
        assert (layout.lower <= u).all()
        assert (u <= layout.upper).all()
    widened = dict(zip((slot.key for slot in layout.slots), layout.slots, strict=True))
    assert widened["torque_offset", "torque", 0].lower == -9e3
    assert widened["torque_offset", "torque", 0].upper < 1e3


class Absolute(Effect):
    """τ = c."""

    name, title, summary, signature, source = "push", "push", "a push", "it is pushed", "none"
    parameters = (
        Parameter("torque", "N·m", -2.0, 3.0, "push", size=0.1),
        Parameter("more", "N·m", -1.0, 1.0, "beside the MJCF's", adds_to="dof_frictionloss"),
    )

    def install(self, loop, rows, joints, values): ...

    def starts(self, scales):
        return [{"torque": scales.torque, "more": scales.torque}]


def test_an_effect_may_have_a_range_in_units():
    sizes = made_sizes(JOINTS, 1e3)
    for effect in (Absolute(), within(Absolute(), sizes.plant, JOINTS, sizes)):
        push = layout_of(effect).slots[0]
        assert (push.lower, push.upper, push.size, push.scale) == (-2.0, 3.0, 0.1, 1.0)
    assert layout_of(effect).slots[-1].lower == -1.0
    light = made_sizes(JOINTS)
    assert layout_of(within(Absolute(), light.plant, JOINTS, light)).slots[-1].lower == -0.3


@pytest.mark.parametrize("scale", ["torqe", "torque +", "x", "plant", 3])
def test_a_scale_that_is_no_formula_of_sizes_is_named(tmp_path, scale):
    from t2l.effects.registry import load

    text = f"""
from t2l.effects import Effect, Parameter
class Mine(Effect):
    name, title, summary, signature, source = "mine", "mine", "mine", "mine", "mine"
    parameters = (Parameter("torque", "N·m", 0.0, 1.0, "mine", scale={scale!r}),)
    def install(self, loop, rows, joints, values): ...
    def starts(self, scales): return [dict(torque=scales.torque)]
"""
    path = tmp_path / "mine.py"
    path.write_text(text)
    with pytest.raises(ConfigurationError, match="parameter 'torque': scale: found"):
        load([path])


def test_a_joint_between_has_a_motor_in_proportion_to_its_link():
    """Where the MJCF has no armature."""
    masses = []
    for factor in (1e-3, 1.0, 1e3):
        xml = '<mujoco><worldbody><body><joint name="a"/><geom size="0.1" mass="{}"/></body>'
        spec = mujoco.MjSpec.from_string(f"{xml.format(factor)}</worldbody></mujoco>")
        builtin()["joint_flexibility"].extend(spec, ("a",))
        masses.append(spec.joint("a").armature / factor)
    np.testing.assert_allclose(masses, masses[1], rtol=1e-12)
