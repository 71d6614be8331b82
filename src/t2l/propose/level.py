"""A constant in place of a curve."""

from dataclasses import replace

import numpy as np

from t2l.effects.law import ALLOWED, Law
from t2l.effects.learned import SplineTorque
from t2l.propose.bases import constant
from t2l.propose.dictionary import weights_in
from t2l.propose.refit import State, with_law, without


def level_of(state: State, curve: SplineTorque) -> Law | None:
    """The constant that could take the place of a curve; None if there is none, or it is there."""
    law = replace(curve.law, follows="constant", of=curve.law.joint)
    new = law not in {other.law for other, _ in state.laws}
    return law if new and "constant" in ALLOWED[law.kind] else None


def levelled(state: State, curve: SplineTorque, law: Law, joints: tuple[str, ...]) -> State:
    """The state with the constant `law` in place of `curve`, at its mean; the last of the laws."""
    mean = np.mean(curve.basis @ state.u[weights_in(state.layout, curve)], keepdims=True)
    level = constant(law, curve.parameters[0].size)
    # one weight has no penalty
    return with_law(without(state, [curve.name]), level, mean, 1.0, joints)
