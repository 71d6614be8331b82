import numpy as np

from t2l.diagnose.joint_growth import single_joints, united
from t2l.effects.registry import builtin
from t2l.effects.term import Layout, Term
from t2l.identify.least_squares import LeastSquares

BACKLASH, FRICTION = builtin()["backlash"], builtin()["coulomb_friction"]


def test_what_splits_a_joint_is_tried_on_single_joints_the_worst_first():
    terms = single_joints([BACKLASH, FRICTION], Layout(()), [1e-6, 4e-6])
    assert [term.joints for term in terms] == [(1,), (0,)]
    assert {term.effect.name for term in terms} == {"backlash"}
    # what one joint has already, both have with the other
    assert single_joints([BACKLASH], Layout([Term(BACKLASH, (0,))]), [1e-6, 4e-6]) == []


def test_two_joints_together_start_from_where_each_ended():
    def fit(joints, friction, play):
        layout = Layout([Term(FRICTION, (0, 1)), Term(BACKLASH, joints)])
        values = {
            "coulomb_friction": {"torque": np.array(friction)},
            "backlash": {
                "play": np.array([play]), "contact_time": np.array([2e-3]),
                "contact_damping": np.array([0.2]), "encoder_on_link": np.array([0.0]),
            },
        }  # fmt: skip
        u = layout.encode(values)
        return LeastSquares(layout, u, np.abs(u))

    wider = united("backlash", fit((2,), [0.1, 0.2], 0.05), fit((0,), [0.3, 0.4], 0.01))
    values = wider.layout.decode(wider.u[None])
    np.testing.assert_allclose(values["backlash"]["play"], [[0.01, 0.05]])
    np.testing.assert_allclose(values["coulomb_friction"]["torque"], [[0.1, 0.2]])
