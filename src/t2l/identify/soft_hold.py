"""Simulations that are held softly to the measurement, where no position is commanded.

A simulation of an arm under commanded torques alone drifts away from the measured one within
seconds, whatever its model. Held by

    τ_hold = I ω² (q_measured − q) + 2 I ω (q̇_measured − q̇)

it does not, and is free on the time scale on which models differ. Where the model is right, the
hold gives nothing; where it lacks a torque δτ that changes slowly, it is off by δτ / (I ω²). This
is an observer with constant gains: Luenberger, An introduction to observers, 1971. I is the mean
over the measured motion of the diagonal of the mass matrix of the robot's own file, so that every
model is held alike.

Between samples the measured motion is a cubic spline. It is not smoothed: the hold itself is a
low-pass, with a noise bandwidth of 5 ω / 8 (Gardner, Phaselock techniques, 2005, chapter 6), 8 Hz.
Of white noise σ at 100 samples a second it follows 0.4 σ, and the error of the right model is
0.96 σ; at 25 samples a second 0.7 σ and 0.75 σ.
"""

from collections.abc import Iterator, Sequence

import mujoco
import numpy as np
from scipy.interpolate import make_interp_spline

from t2l.recordings.recording import Recording, held
from t2l.sim.schedule import Hold

# tuned: twice the frequency at which an arm swings that is 0.25 m long: it stays where it stands up
HOLD_HZ = 2.0
# bound: between two samples; in a longer gap nobody knows what to hold to
LONGEST_GAP_S = 0.1
DEGREE = 3  # numerics: of the curve between samples: its derivative has no steps
POSES = 100  # numerics: over which the inertia of a recording is averaged

Gains = tuple[np.ndarray, np.ndarray]


def hold_gains(model: mujoco.MjModel, recordings: Sequence[Recording]) -> Gains | None:
    """N·m/rad and N·m·s/rad (nrec, njoint) that hold; zero where positions are commanded.

    None if they are in all recordings.

    Args:
        model: the robot without effects.
    """
    if not any(recording.drifts for recording in recordings):
        return None
    omega = 2 * np.pi * HOLD_HZ
    inertia = np.array([_mean_inertia(model, r) if r.drifts else 0 * r.kp for r in recordings])
    return inertia * omega**2, 2 * inertia * omega


def _mean_inertia(model: mujoco.MjModel, recording: Recording) -> np.ndarray:
    """Of the diagonal of the mass matrix over the measured motion, (njoint,) kg·m²."""
    data, mass = mujoco.MjData(model), np.zeros((model.nv, model.nv))
    at = [model.joint(name).qposadr[0] for name in recording.joints]
    dofs = [model.joint(name).dofadr[0] for name in recording.joints]
    rows = np.unique(np.linspace(0, len(recording.time) - 1, POSES).astype(int))
    found = []
    for q in held(recording.q)[rows]:
        data.qpos[at] = q
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fullM(model, data, mass)
        found.append(np.diag(mass)[dofs])
    return np.mean(found, axis=0)


def soft_hold(recordings: Sequence[Recording], gains: Gains, at: np.ndarray) -> Hold:
    """What holds recordings at times since their start.

    Args:
        gains: of `hold_gains`, of these recordings.
        at: (ntick,) s.
    """
    q, dq, part = np.zeros((3, len(at), *gains[0].shape))
    for r, recording in enumerate(recordings):
        if not recording.drifts:
            continue
        for j in range(len(recording.joints)):
            for clock, values in _pieces(*recording.measured(j)):
                now = (at >= clock[0]) & (at <= clock[-1])
                between = make_interp_spline(clock, values, k=DEGREE)
                q[now, r, j], dq[now, r, j] = between(at[now]), between(at[now], 1)
                part[now, r, j] = 1.0
    return Hold(q, dq, part * gains[0], part * gains[1])


def _pieces(clock: np.ndarray, values: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Samples without a long gap between them, of as many as a curve takes."""
    gap = np.diff(clock)
    # numerics: of a slow log, some rows
    ends = np.flatnonzero(gap > max(LONGEST_GAP_S, 3 * np.median(gap))) + 1
    for part in np.split(np.arange(len(clock)), ends):
        if len(part) > DEGREE:
            yield clock[part], values[part]
