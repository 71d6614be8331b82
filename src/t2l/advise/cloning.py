"""The order of gains for behaviour cloning, told before any policy is trained.

A policy errs by as much as its labels are hard to tell; the loop lets some of that through:

    predicted error² = mean over joints of amplification · label difficulty

The amplification is exact: the variance of a joint's position over that of independent errors of
its commands, each held for a period of the policy, by the discrete Lyapunov equation of the loop.
Label difficulty lies between two measures of what alike states of other demonstrations leave
untold: of commands as positions, which counts too little how it differs from cell to cell, and of
commands from where the joint is, which counts it too much; see docs/results_errors.md.
"""

from collections.abc import Sequence

import numpy as np

from t2l.advise.attenuation import held_variance
from t2l.advise.loop import closed, sampled
from t2l.advise.machine import Machine

# fitted: of displacements in the product, by `python -m benchmarks advice`, which reports each task
# by what the others choose
BLEND = 0.5
# fitted: likewise, of one error of a policy with its next
CORRELATION = 0.0


def difficulty(c: np.ndarray, kp: np.ndarray, kd: np.ndarray) -> np.ndarray:
    """wᵀ C w, rad² (cell, n): the squared error of commands q + τ/Kp + (Kd/Kp) q̇.

    Args:
        c: (n, 3, 3), see `t2l.advise.beforehand.residuals`.
        kp, kd: (cell, n) N·m/rad and N·m·s/rad.
    """
    w = np.stack([np.ones_like(kp), 1 / kp, kd / kp], axis=-1)
    return np.einsum("knc,ncd,knd->kn", w, c, w)


def blended(positions: np.ndarray, displacements: np.ndarray, blend: float = BLEND) -> np.ndarray:
    """Between two difficulties, rad²: a geometric mean with the weight `blend` on the second."""
    return positions ** (1 - blend) * displacements**blend


def predicted_error(amplification: np.ndarray, labels: np.ndarray) -> np.ndarray:
    """rad (cell,), root of the mean over joints; both (cell, n)."""
    return np.sqrt((amplification * labels).mean(axis=1))


def amplifications(
    machine: Machine,
    kp: np.ndarray,
    kd: np.ndarray,
    policy_rate_hz: float,
    correlations: Sequence[float] = (CORRELATION,),
) -> np.ndarray:
    """Var[δq] / σ² of every joint under gains (cell, n), (ncorrelation, cell, n).

    Each joint at its mean inertia, the others held; infinite where the loop does not settle.

    Args:
        correlations: of one error of a command with the next.
    """
    steps = max(1, round(machine.rate_hz / policy_rate_hz))
    found = np.full((len(correlations), *kp.shape), np.inf)
    for j in range(kp.shape[1]):
        plant = sampled(machine.alone(j).mean(), machine.signals.period_s)
        factor = machine.gain_factor[j]
        loop = closed(
            plant.of(np.zeros(len(kp), int)), factor[0] * kp[:, j : j + 1],
            factor[1] * kd[:, j : j + 1], machine.signals.of(j),
        )  # fmt: skip
        settles = np.abs(np.linalg.eigvals(loop.f)).max(axis=1) < 1
        for cell in np.flatnonzero(settles):
            for i, correlation in enumerate(correlations):
                found[i, cell, j] = held_variance(
                    loop.f[cell], loop.g[cell, :, 0], steps, correlation, loop.h[0]
                )
    return found
