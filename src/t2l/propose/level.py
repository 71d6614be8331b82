"""A constant in place of a curve."""

from dataclasses import replace

import numpy as np

from t2l.effects.law import ALLOWED, Law
from t2l.effects.learned import SplineTorque
from t2l.propose.dictionary import joined, term_of, weights_in
from t2l.propose.refit import State, without


def levels(state: State) -> dict[SplineTorque, Law]:
    """The curves of a state that a constant could take the place of, and its law."""
    found = {}
    for effect, _ in state.laws:
        law = replace(effect.law, follows="constant", of=effect.law.joint)
        if "constant" in ALLOWED[law.kind] and law not in {other.law for other, _ in state.laws}:
            found[effect] = law
    return found


def levelled(state: State, curve: SplineTorque, law: Law, joints: tuple[str, ...]) -> State:
    """The state with the constant `law` in place of `curve`, at its mean; the last of the laws."""
    size = curve.parameters[0].size
    level = SplineTorque(law, np.array([0.0, 1.0]), np.ones((2, 1)), size)
    mean = np.mean(curve.basis @ state.u[weights_in(state.layout, curve)])
    bare = without(state, [curve.name])
    layout, u = joined(bare.layout, bare.u, [term_of(level, joints)])
    u[weights_in(layout, level)] = mean
    kept = [(effect, factor) for effect, factor in state.laws if effect is not curve]
    return State(layout, u, (*kept, (level, 1.0)))
