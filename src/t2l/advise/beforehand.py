"""What can be said of a cell before any policy is trained: of its loop, and of demonstrations.

Failure is bounded by amplification times validation loss (the idea of arXiv 2604.14484). Both have
a forecast. A retargeted command is linear in what a demonstration recorded,

    q_des = q + τ / Kp + (Kd / Kp) q̇ = wᵀ (q, τ, q̇),   w = (1, 1 / Kp, Kd / Kp),

and so is the mean of the commands that followed alike states (k nearest neighbours of other
demonstrations). C, the mean product of what this mean leaves of (q, τ, q̇), 3 × 3 for each joint,
thus holds all that demonstrations say, whatever the gains:

- label difficulty wᵀ C w: the squared error of a command in rad²
- injection: how far a joint has gone after one hold, per error of its command
- contraction: what a hold leaves of a disturbance, the spectral radius of the loop over it
- amplification Var[δq] / σ², which injection and contraction make, see `t2l.advise.attenuation`
- predicted error, rad: the root of amplification times label difficulty, mean over joints
"""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from t2l.advise.attenuation import held_variance, step_matrices

RECORDED = ("q", "torque", "velocity")
# columns of C, by rows of its upper triangle
PAIRS = [(i, k) for i in range(3) for k in range(i, 3)]
RESIDUALS = tuple(f"{RECORDED[i]}_{RECORDED[k]}" for i, k in PAIRS)
NEIGHBOURS = 5  # convention: few, so that a mean is of alike states
AT_ONCE = 256  # numerics: states whose distances are held at a time


def residuals(
    states: Sequence[np.ndarray],
    recorded: Sequence[np.ndarray],
    ahead: int,
    every: int = 1,
    displacements: bool = False,
) -> np.ndarray:
    """C (njoint, 3, 3), in products of rad, N·m and rad/s; mean over `ahead` instants.

    Args:
        states: (n, nstate) of each demonstration, at the policy's rate.
        recorded: (n, njoint, 3) of each: q, τ and q̇ there.
        ahead: how many instants, from that of the state on, a policy tells commands of.
        every: of how many states one is asked for; neighbours are sought among all.
        displacements: commands are told from where the joint is, which a policy sees, and not as
            positions; so alike states may differ in position.

    Raises:
        ValueError: fewer than two demonstrations: none has neighbours in others.
    """
    if len(states) < 2:
        raise ValueError(f"found {len(states)} demonstrations; allowed: two or more")
    whose = np.repeat(np.arange(len(states)), [len(s) for s in states])
    features, futures = _standard(np.concatenate(states)), np.concatenate(
        [_future(one, ahead, displacements) for one in recorded]
    )  # fmt: skip
    asked = np.arange(0, len(features), every)
    total = 0.0
    for some in np.array_split(asked, max(1, len(asked) // AT_ONCE)):
        near = _nearest(features, whose, some)
        left = futures[some] - futures[near].mean(axis=1)
        total = total + np.einsum("najc,najd->jcd", left, left) / ahead
    return total / len(asked)


def _standard(states: np.ndarray) -> np.ndarray:
    spread = states.std(axis=0)
    moves = spread > 1e-9 * (1 + np.abs(states).max(axis=0))
    return (states - states.mean(axis=0))[:, moves] / spread[moves]


def _future(recorded: np.ndarray, ahead: int, displacements: bool) -> np.ndarray:
    """(n, ahead, njoint, 3); past the end stands the last."""
    at = np.arange(len(recorded))[:, None] + np.arange(ahead)
    future = recorded[np.minimum(at, len(recorded) - 1)]
    if displacements:
        future[..., 0] -= recorded[:, None, :, 0]
    return future


def _nearest(features: np.ndarray, whose: np.ndarray, some: np.ndarray) -> np.ndarray:
    """(nsome, NEIGHBOURS) states of other demonstrations."""
    size = (features**2).sum(axis=1)
    distance = size - 2 * features[some] @ features.T
    distance[whose[some][:, None] == whose] = np.inf
    return np.argpartition(distance, NEIGHBOURS, axis=1)[:, :NEIGHBOURS]


def forecast(
    kp: float, kd: float, inertia: np.ndarray, c: np.ndarray, timestep_s: float, steps: int
) -> dict[str, float]:
    """The five numbers of one cell, means over joints.

    Args:
        kp, kd: N·m/rad and N·m·s/rad.
        inertia: (njoint,) kg·m², about each joint.
        c: (njoint, 3, 3), see `residuals`.
        timestep_s, steps: of the simulation, and how many of them a command is held for.
    """
    w = np.array([1.0, 1 / kp, kd / kp])
    difficulty = np.einsum("c,jcd,d->j", w, c, w)
    injection, contraction, amplification = np.array(
        [_loop(*step_matrices(kp, kd, float(m), timestep_s), steps) for m in inertia]
    ).T
    return {
        "label_difficulty": float(difficulty.mean()),
        "injection": float(injection.mean()),
        "contraction": float(contraction.mean()),
        "amplification": float(amplification.mean()),
        "predicted_error": float(np.sqrt((amplification * difficulty).mean())),
    }


def _loop(a: np.ndarray, b: np.ndarray, steps: int) -> tuple[float, float, float]:
    pushed = np.zeros(2)
    for _ in range(steps):
        pushed = a @ pushed + b
    held = np.linalg.matrix_power(a, steps)
    radius = np.abs(np.linalg.eigvals(held)).max()
    return abs(pushed[0]), float(radius), held_variance(a, b, steps)


def matrices(table: pd.DataFrame) -> np.ndarray:
    """C (njoint, 3, 3) of a kept table with columns `RESIDUALS`, one row a joint."""
    c = np.empty((len(table), 3, 3))
    for (i, k), name in zip(PAIRS, RESIDUALS, strict=True):
        c[:, i, k] = c[:, k, i] = table[name]
    return c
