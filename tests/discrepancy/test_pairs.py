import numpy as np

from t2l.discrepancy.fit import Fit
from t2l.discrepancy.pairs import _joined
from t2l.effects.registry import builtin
from t2l.effects.term import Layout, Term


def test_an_effect_that_some_joints_have_already_is_in_a_pair_once():
    effects = builtin()
    coulomb, viscous = effects["coulomb_friction"], effects["viscous_friction"]
    adopted = Term(coulomb, (0,))
    alone = Layout([adopted, Term(viscous, (0, 1))])
    wider = Layout([Term(coulomb, (0, 1))])
    fit = Fit(alone, np.arange(1.0, len(alone) + 1), np.ones(len(alone)))
    other = Fit(wider, np.array([0.3, 0.7]), np.ones(2))
    pair = _joined(fit, other, "coulomb_friction", diagonal=False)
    keys = [slot.key for slot in pair.layout.slots]
    assert len(set(keys)) == len(keys) == 4
    values = pair.layout.decode(pair.u[None])
    assert [v[0].tolist() for v in values["coulomb_friction"].values()] == [[0.3, 0.7]]
    assert values["viscous_friction"].keys() == {p.name for p in viscous.parameters}
