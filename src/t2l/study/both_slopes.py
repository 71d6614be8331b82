"""Claims about the slopes with Kp and with Kd at once."""

from collections.abc import Mapping

from t2l.stats.slopes import Slopes
from t2l.stats.verdict import Finding, every, signed
from t2l.study.published.numbers import Published
from t2l.study.words import among


def both_slopes(fit: Slopes, signs: Mapping[str, int], n: int, published: Published) -> Finding:
    """Whether each slope has its sign; the greater p decides.

    Args:
        signs: of `kp` and of `kd`; `published.values` has a number for each.
        n: cells.
    """
    found = every(
        [
            signed(
                *(getattr(fit, gain), getattr(fit, f"{gain}_error"), fit.freedom, sign, n),
                claimed=published.values[gain],
            )
            for gain, sign in signs.items()
        ]
    )
    return among(found, "{:+.3f} and {:+.3f}", *([getattr(fit, gain)] for gain in signs))
