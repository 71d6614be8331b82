import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from t2l.identify.actuator_parameters import BOX, PARAMETERS, decode, encode, on_bound

points = st.lists(st.floats(0, BOX), min_size=6, max_size=6).map(lambda x: np.array([x]))


@given(points)
def test_a_point_leads_to_parameters_within_bounds_and_back(x):
    parameters = decode(x)
    for p in PARAMETERS:
        slack = 1e-12 * p.upper
        assert np.all(parameters[p.name] >= p.lower - slack)
        assert np.all(parameters[p.name] <= p.upper + slack)
    np.testing.assert_allclose(encode(parameters), x, atol=1e-9)


def test_gains_are_searched_by_powers_of_two():
    parameters = decode(np.full((1, 12), 4.0))
    np.testing.assert_allclose(parameters["stiffness"], [[16.0, 16.0]])
    np.testing.assert_allclose(parameters["armature"], [[0.2, 0.2]])


def test_what_ends_on_a_bound_is_named():
    values = {name: values[0] for name, values in decode(np.full((1, 12), 5.0)).items()}
    assert on_bound(values) == []
    values["damping"] = np.array([1.0, 50.0])
    values["viscous_friction"] = np.array([0.5, 1.0])
    assert on_bound(values) == [("damping", 0), ("viscous_friction", 1)]
