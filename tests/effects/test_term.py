import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from t2l.effects.effect import within
from t2l.effects.registry import builtin
from t2l.effects.term import Layout, Term
from tests.effects.made import made_sizes

JOINTS = 3


@st.composite
def layouts(draw):
    """Some effects, each on some joints."""
    names = draw(st.lists(st.sampled_from(sorted(builtin())), unique=True, max_size=4))
    joints = st.sets(st.integers(0, JOINTS - 1), min_size=1).map(sorted).map(tuple)
    sizes = made_sizes(("a", "b", "c"))
    return Layout([Term(within(builtin()[n], sizes.plant, sizes.joints, sizes), draw(joints))
                   for n in names])  # fmt: skip


def test_a_title_names_the_joints_where_not_all_have_it():
    joints, friction = ("a", "b", "c"), builtin()["coulomb_friction"]
    assert Term(friction, (0, 1, 2)).title(joints) == "Coulomb friction"
    assert Term(friction, (2,)).title(joints) == "Coulomb friction on c"
    assert Term(friction, (0, 2)).title(joints) == "Coulomb friction on a and c"


@settings(deadline=None, max_examples=30)
@given(layouts(), st.integers(1, 3), st.randoms(use_true_random=False))
def test_parameters_survive_the_way_to_a_vector_and_back(layout, count, random):
    share = np.array([[random.random() for _ in range(len(layout))] for _ in range(count)])
    u = layout.lower + share * (layout.upper - layout.lower)
    values = layout.decode(u)
    for row in range(count):
        one = {e: {p: v[row] for p, v in of.items()} for e, of in values.items()}
        np.testing.assert_allclose(layout.encode(one), u[row], rtol=1e-9, atol=1e-9)
    for term in layout.terms:
        for parameter in term.effect.parameters:
            found = values[term.effect.name][parameter.name]
            assert found.shape == (count, len(term.joints) if parameter.per_joint else 1)
            joints = list(term.joints) if parameter.per_joint else [0]
            lower, upper = (
                np.broadcast_to(bound, JOINTS)[joints]
                for bound in (parameter.lower, parameter.upper)
            )
            rounding = 1e-9 * np.maximum(np.abs(lower), np.abs(upper))
            assert (found >= lower - rounding).all()
            assert (found <= upper + rounding).all()


@settings(deadline=None, max_examples=30)
@given(layouts())
def test_slots_name_what_the_vector_holds(layout):
    assert len(layout.slots) == len(layout.lower) == len(layout.upper) == len(layout)
    u = np.arange(float(len(layout)))
    values = layout.decode(u[None])
    theta = layout.theta(u)
    for i, slot in enumerate(layout.slots):
        found = values[slot.term.effect.name][slot.parameter.name][0]
        at = 0 if slot.joint is None else slot.term.joints.index(slot.joint)
        assert found[at] == theta[i]


def test_values_beyond_a_bound_end_on_it():
    layout = Layout([Term(builtin()["torque_constant"], (0, 1))])
    u = layout.encode({"torque_constant": {"factor": np.array([1e-9, np.inf])}})
    np.testing.assert_allclose(layout.theta(u), [0.1, 5.0])


def test_effects_act_from_the_command_to_the_joint():
    """Whatever order they were adopted in: a torque is limited before it lags behind."""
    names = ["torque_constant", "actuator_bandwidth", "torque_saturation", "command_filter"]
    layouts = [Layout([Term(builtin()[n], (0,)) for n in o]) for o in (names, names[::-1])]
    orders = [[term.effect.name for term in layout.terms] for layout in layouts]
    assert orders[0] == orders[1] == names[::-1]


def test_no_effect_is_an_empty_vector():
    layout = Layout([])
    assert layout.encode({}).shape == (0,)
    assert layout.decode(np.zeros((4, 0))) == {}


def test_a_value_for_one_number_serves_all_joints():
    layout = Layout([Term(builtin()["torque_offset"], (0, 2))])
    assert layout.encode({"torque_offset": {"torque": 0.3}}) == pytest.approx([0.3, 0.3])
