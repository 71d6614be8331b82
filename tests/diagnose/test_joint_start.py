import numpy as np

from t2l.diagnose.joint_start import joined, starts_together
from t2l.effects.registry import builtin
from t2l.effects.term import Layout, Term
from t2l.identify.least_squares import LeastSquares


def fitted(layout, u):
    return LeastSquares(layout, np.array(u), np.ones(len(layout)))


def test_effects_are_joined_with_the_values_that_each_alone_was_fitted_to():
    coulomb, viscous, delay = (
        builtin()[name] for name in ("coulomb_friction", "viscous_friction", "command_delay")
    )
    # the model so far has the delay, and friction on the first joint
    one = fitted(Layout([Term(delay, (0, 1)), Term(coulomb, (0,)), Term(viscous, (0, 1))]),
                 [0.01, 0.5, 0.3, 0.4])  # fmt: skip
    two = fitted(Layout([Term(delay, (0, 1)), Term(coulomb, (0, 1))]), [0.02, 0.6, 0.7])
    names = ("viscous_friction", "coulomb_friction")
    both = joined([one, two], names, False)
    found = dict(zip([s.key for s in both.layout.slots], both.u, strict=True))
    assert found == {
        ("command_delay", "delay", None): 0.01,
        ("coulomb_friction", "torque", 0): 0.6,
        ("coulomb_friction", "torque", 1): 0.7,
        ("viscous_friction", "damping", 0): 0.3,
        ("viscous_friction", "damping", 1): 0.4,
    }
    starts = starts_together(both, names)
    keys = [s.key[0] for s in both.layout.slots]
    np.testing.assert_array_equal(starts[0], both.u)
    for name, start in zip(names, starts[1:], strict=True):
        absent = np.array(keys) == name
        np.testing.assert_array_equal(start, np.where(absent, 0.0, both.u))
