import numpy as np

from t2l.diagnose.joint_growth import key_of, terms_to_try, united
from t2l.effects.registry import builtin
from t2l.effects.term import Layout, Term
from t2l.identify.least_squares import LeastSquares
from t2l.identify.prediction import Predictor
from tests.diagnose.made import recording, swing, two_pendulums

BACKLASH, FRICTION = builtin()["backlash"], builtin()["coulomb_friction"]


def test_what_splits_a_joint_is_tried_on_single_joints_the_worst_first(tmp_path):
    both = recording(two_pendulums(tmp_path), lambda t: np.stack([swing()(t)] * 2, axis=1))
    predictor = Predictor(both.robot, [both], threads=1)
    residual = np.where(predictor.samples.joint == 1, 2e-3, 1e-3)
    terms = terms_to_try([BACKLASH, FRICTION], Layout(()), predictor, residual)
    assert [key_of(t) for t in terms] == [
        ("backlash", (0, 1)), ("coulomb_friction", (0, 1)), ("backlash", (1,)), ("backlash", (0,)),
    ]  # fmt: skip
    # what one joint has already, both have with the other
    adopted = Layout([Term(BACKLASH, (0,))])
    assert len(terms_to_try([BACKLASH], adopted, predictor, residual)) == 1


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
