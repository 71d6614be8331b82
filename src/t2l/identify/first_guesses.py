"""The magnitudes of an effect that are tried first, checked as they come from its author."""

import numpy as np

from t2l.effects.blame import blaming
from t2l.effects.effect import Effect, Scales


def first_guesses(effect: Effect, sizes: Scales, njoint: int) -> list[dict[str, np.ndarray]]:
    """An effect's first guesses, each parameter finite and of the shape it must have."""
    with blaming([effect], "to make first guesses (starts)"):
        starts = list(effect.starts(sizes))
        if not starts:
            raise ValueError("it returned none; allowed: at least one")
        for start in starts:
            check_guess(effect, start, njoint)
    return starts


def check_guess(effect: Effect, guess: dict[str, np.ndarray], njoint: int) -> None:
    """Find what is no guess.

    Raises:
        ValueError: a parameter is missing, of another shape or not finite.
    """
    names = [parameter.name for parameter in effect.parameters]
    if not isinstance(guess, dict) or set(guess) != set(names):
        raise ValueError(f"found {guess!r}; allowed: a number or an array for {', '.join(names)}")
    for parameter in effect.parameters:
        value = np.asarray(guess[parameter.name], float)
        np.broadcast_to(value, (njoint if parameter.per_joint else 1,))
        if not np.isfinite(value).all():
            raise ValueError(f"found {value} for {parameter.name}; allowed: finite numbers")
