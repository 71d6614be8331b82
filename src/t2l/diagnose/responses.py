"""The responses of the simulation to each effect, as `stability_selection` takes them."""

from collections.abc import Mapping

import numpy as np

from t2l.diagnose.evidence import Evidence
from t2l.diagnose.stability_selection import Dictionary, Group
from t2l.effects.effect import Effect
from t2l.identify.block_bootstrap import blocks
from t2l.identify.least_squares import LeastSquares


def dictionary_of(
    fits: Mapping[str, LeastSquares],
    mild: Mapping[str, np.ndarray],
    so_far: LeastSquares,
    evidence: Evidence,
) -> Dictionary:
    """Responses to each effect: to a little of it, and where its fit has ended.

    While another effect is missing a fit may end where it says nothing.
    """
    groups = []
    for name, fit in fits.items():
        if not np.isfinite(fit.loss):
            continue
        layout = fit.layout
        effect = next(t.effect for t in layout.terms if t.effect.name == name)
        # a derivative across a bound would promise what cannot be
        inside = fit.free & (fit.u > layout.lower) & (fit.u < layout.upper)
        own = [i for i, s in enumerate(layout.slots) if s.key[0] == name and inside[i]]
        moved = (fit.residual - so_far.residual)[:, None]
        groups.append(
            Group(
                name,
                np.column_stack([mild[name], moved, np.nan_to_num(fit.jacobian[:, own])]),
                sum(slot.key[0] == name for slot in layout.slots),
                frozenset(effect.contains)
                | {n for n, f in fits.items() if name in _effect(f, n).contains},
            )
        )
    samples, mask = evidence.screen.samples, evidence.screen_mask
    block = blocks(samples.recording[mask], samples.time[mask])
    return Dictionary(-so_far.residual, so_far.jacobian, groups, block)


def _effect(fit: LeastSquares, name: str) -> Effect:
    return next(t.effect for t in fit.layout.terms if t.effect.name == name)
