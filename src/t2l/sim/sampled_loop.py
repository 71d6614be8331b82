"""Whether a loop that holds its torque between its ticks settles, or chatters at its own rate.

Under a torque τ held for a period h, M q̈ + D q̇ + K q = τ moves x = (q, q̇) exactly by
x' = A x + B τ, and under τ = −Kp q − Kd q̇ the loop by x' = (A − B [Kp Kd]) x. It settles if all
eigenvalues lie within the unit circle. For one joint without D and K that is, by Jury's criterion,
Kp h/2 < Kd and Kd h/M < 2: what is damped within half a tick is thrown back harder in the next.

Source: Åström and Wittenmark, Computer-controlled systems, 1997, sections 2.3 and 3.2.
"""

import numpy as np
from scipy.linalg import eigh, expm

HALVINGS = 20  # numerics: the longest stable period to a part in a million of the first


def transition(
    mass: np.ndarray,
    damping: np.ndarray,
    stiffness: np.ndarray,
    kp: np.ndarray,
    kd: np.ndarray,
    period_s: np.ndarray,
) -> np.ndarray:
    """What one tick makes of the positions and velocities (q, q̇), (k, 2n, 2n).

    Args:
        mass: (k, n, n) kg·m², of k loops of n joints.
        damping, stiffness: of the joints, (k, n) N·m·s/rad and N·m/rad.
        kp, kd: of the controllers, (k, n) N·m/rad and N·m·s/rad.
        period_s: (k,) from tick to tick.
    """
    k, n = kp.shape
    q, dq, torque = slice(0, n), slice(n, 2 * n), slice(2 * n, 3 * n)
    lighter = np.linalg.inv(mass)
    rates = np.zeros((k, 3 * n, 3 * n))
    rates[:, q, dq] = np.eye(n)
    rates[:, dq, q] = -lighter * stiffness[:, None]
    rates[:, dq, dq] = -lighter * damping[:, None]
    rates[:, dq, torque] = lighter
    held = expm(rates * period_s[:, None, None])[:, : 2 * n]
    gains = np.concatenate([kp, kd], axis=1)[:, None]
    ways = np.concatenate([held[..., torque]] * 2, axis=2)
    return held[..., : 2 * n] - ways * gains


def chatter(step: np.ndarray) -> np.ndarray:
    """Factor a tick by which what alternates from tick to tick grows, (k,); 0 where nothing does.

    That is a motion with a period of less than four ticks, which no joint has of its own.

    Args:
        step: (k, 2n, 2n), see `transition`.
    """
    # what is beyond all numbers is left to the simulation
    finite = np.isfinite(step).all(axis=(1, 2))
    found = np.linalg.eigvals(np.where(finite[:, None, None], step, 0.0))
    return np.where(found.real < 0, np.abs(found), 0.0).max(axis=1)


def longest_stable_s(
    mass: np.ndarray,
    damping: np.ndarray,
    stiffness: np.ndarray,
    kp: np.ndarray,
    kd: np.ndarray,
    period_s: np.ndarray,
) -> float:
    """The longest period up to `period_s` (1,) at which one loop does not chatter, s.

    Args:
        mass, damping, stiffness, kp, kd: of one loop, see `transition`.
    """

    def settles(period: float) -> bool:
        step = transition(mass, damping, stiffness, kp, kd, np.array([period]))
        return bool(chatter(step)[0] <= 1)

    low, high = 0.0, float(period_s[0])
    if settles(high):
        return high
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if settles(middle) else (low, middle)
    return low


def damping_number(mass: np.ndarray, kd: np.ndarray, period_s: float) -> tuple[float, int]:
    """Kd h/M of the motion of a loop that has the most, and the joint that damps it most.

    Args:
        mass: (n, n) kg·m².
        kd: (n,) N·m·s/rad.
    """
    numbers, motions = eigh(np.diag(kd) * period_s, mass)
    return float(numbers[-1]), int(np.argmax(kd * motions[:, -1] ** 2))


def stiffness_number(mass: np.ndarray, kp: np.ndarray, period_s: float) -> tuple[float, int]:
    """Kp h²/M, likewise; `kp` in N·m/rad."""
    return damping_number(mass, kp, period_s**2)
