"""The variance of a joint's position under noise on its commanded position.

    m δq̈ + Kd δq̇ + Kp δq = Kp δa,   δa i.i.d. of standard deviation σ, each held for h

The study (its Appendix A, Theorem 1) takes δa for white noise of intensity σ² and finds
Var[δq] = σ² Kp / (2 Kd), whatever m. Noise that is held for h has the intensity σ² h at low
frequencies, so that in SI units

    Var[δq] = σ² h Kp / (2 Kd),

where h Kp / (2 Kd) is small. `held_variance` is exact for any h.
"""

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import solve_discrete_lyapunov

# up to this h Kp / (2 Kd) the theorem is to hold within its own size
SMALL = 0.1


def attenuation(kp: ArrayLike, kd: ArrayLike, hold_s: ArrayLike) -> np.ndarray:
    """h Kp / (2 Kd), dimensionless: the theorem's Var[δq] / σ².

    Args:
        kp: N·m/rad.
        kd: N·m·s/rad.
        hold_s: how long each command is held, s.
    """
    return np.asarray(hold_s) * np.asarray(kp) / (2 * np.asarray(kd))


def effective_error(kp: ArrayLike, kd: ArrayLike, mse: ArrayLike, hold_s: float) -> np.ndarray:
    """√(h Kp / (2 Kd)) ε_π, what errors of actions leave of errors of positions.

    The study's Corollary 1 with the hold, ε_π being the root of the validation error.

    Args:
        kp, kd, hold_s: see `attenuation`.
        mse: mean squared error of a policy's actions; in rad² the result is in rad.
    """
    return np.sqrt(attenuation(kp, kd, hold_s) * np.asarray(mse))


def step_matrices(
    kp: float, kd: float, inertia: float, timestep_s: float
) -> tuple[np.ndarray, np.ndarray]:
    """A (2, 2), B (2,) of (δq, δq̇) over one timestep: x' = A x + B δa.

    The torque is that of the end of the timestep, as `t2l.sim.batch` has it:
    m (v' − v) / dt = Kp (δa − q') − Kd v' and q' = q + dt v'.

    Args:
        kp, kd: N·m/rad and N·m·s/rad.
        inertia: kg·m².
    """
    dt = timestep_s
    velocity = np.array([-dt * kp, inertia]) / (inertia + dt * kd + dt**2 * kp)
    push = dt * kp / (inertia + dt * kd + dt**2 * kp)
    return np.array([[1 + dt * velocity[0], dt * velocity[1]], velocity]), push * np.array([dt, 1])


def continuous_matrices(
    kp: float, kd: float, inertia: float, interval_s: float
) -> tuple[np.ndarray, np.ndarray]:
    """The same of a joint in continuous time over an interval in which the command is constant.

    What differs is the integrator's own: to first order it adds a damping of Kp dt.
    """
    # seconds to import, for many jobs that need no matrices
    from scipy.signal import cont2discrete

    a = np.array([[0, 1], [-kp / inertia, -kd / inertia]])
    b = np.array([[0], [kp / inertia]])
    state, pushed, *_ = cont2discrete((a, b, np.eye(2), np.zeros((2, 1))), interval_s)
    return state, pushed[:, 0]


def held_variance(
    a: np.ndarray,
    b: np.ndarray,
    steps: int,
    correlation: float = 0.0,
    read: np.ndarray | None = None,
) -> float:
    """Var[δq] / σ² of a joint, exact, as a mean over the hold.

    Each error is e' = ρ e + √(1 − ρ²) w with w independent. Where commands change, the covariance P
    of (x, e) solves P = F P Fᵀ + Q (the discrete Lyapunov equation), F holding A and B over a hold;
    the variance in between follows from it. With ρ towards 1 the arm follows: the variance is σ².

    Args:
        a, b: (N, N) and (N,) over one step, see `step_matrices`.
        steps: that a command is held for, at the end of each of which the variance is taken.
        correlation: ρ, of one error with the next, from 0 to below 1.
        read: (N,) what of the state is δq; its first element by default.
    """
    size = len(a)
    states, inputs = [np.eye(size)], [np.zeros(size)]
    for _ in range(steps):
        states.append(a @ states[-1])
        inputs.append(a @ inputs[-1] + b)
    over = np.zeros((size + 1, size + 1))
    over[:size, :size], over[:size, size], over[size, size] = states[-1], inputs[-1], correlation
    fresh = np.zeros_like(over)
    fresh[size, size] = 1 - correlation**2
    covariance = solve_discrete_lyapunov(over, fresh)
    read = np.eye(size)[0] if read is None else read
    seen = np.array(
        [[*(read @ state), read @ held] for state, held in zip(states[1:], inputs[1:], strict=True)]
    )
    return float(np.einsum("ti,ij,tj->t", seen, covariance, seen).mean())


def time_constant_s(kp: float, kd: float, inertia: float, timestep_s: float) -> float:
    """Seconds in which the slowest part of a joint's motion falls to 1/e; see `step_matrices`."""
    a, _ = step_matrices(kp, kd, inertia, timestep_s)
    return float(-timestep_s / np.log(np.abs(np.linalg.eigvals(a)).max()))
