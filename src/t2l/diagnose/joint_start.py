"""Several effects in one fit, begun where each alone has ended."""

from collections.abc import Sequence

import numpy as np

from t2l.effects.term import Layout
from t2l.identify.least_squares import LeastSquares


def joined(fits: Sequence[LeastSquares], names: Sequence[str], diagonal: bool) -> LeastSquares:
    """One fit of the effects `names`, the i-th as in `fits[i]`, beside those they share."""
    first = fits[0]
    # the model so far may have one of them on some joints already
    terms = [t for t in first.layout.terms if t.effect.name not in names]
    own = [
        next(t for t in fit.layout.terms if t.effect.name == name)
        for fit, name in zip(fits, names, strict=True)
    ]
    layout = Layout([*terms, *own])
    u, size = {}, {}
    for fit, name in reversed(list(zip(fits, names, strict=True))):
        for slot, value, scale in zip(fit.layout.slots, fit.u, fit.size, strict=True):
            if slot.key[0] == name or slot.key[0] not in names:
                u[slot.key], size[slot.key] = value, scale
    keys = [slot.key for slot in layout.slots]
    given = {key: column for key, column in first.given.items() if key[0] not in names}
    return LeastSquares(
        layout, np.array([u[k] for k in keys]), np.array([size[k] for k in keys]), diagonal,
        tolerance=first.tolerance, given=given,
    )  # fmt: skip


def starts_together(fit: LeastSquares, names: Sequence[str]) -> np.ndarray:
    """Starts (m, n): as each alone was fitted, and with each absent in turn.

    What one was fitted to while the other was missing may lie far off.
    """
    return np.array([fit.u, *(_without(fit, name) for name in names)])


def _without(fit: LeastSquares, name: str) -> np.ndarray:
    """u (n,) of a fit with effect `name` absent, or as nearly as its bounds allow."""
    u = fit.u.copy()
    for i, slot in enumerate(fit.layout.slots):
        if slot.term.effect.name == name and not np.isnan(slot.parameter.neutral):
            u[i] = fit.layout.neutral[i]
    return u
