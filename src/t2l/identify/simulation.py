"""Variants of a plant simulated in one batch and read where the recordings were measured."""

from collections.abc import Sequence

import mujoco
import numpy as np

from t2l.effects.blame import blaming
from t2l.effects.effect import Effect
from t2l.effects.term import Layout
from t2l.sim.servo import Schedule, ServoLoop


def simulate(
    model: mujoco.MjModel,
    joints: tuple[str, ...],
    schedule: Schedule,
    substeps: int,
    variants: Sequence[tuple[Layout, np.ndarray]],
    wanted: Sequence[np.ndarray],
    velocity: bool = False,
    threads: int = 1,
) -> tuple[np.ndarray, ...]:
    """Position (m, k) of each variant at each wanted sample, NaN where it diverged.

    Args:
        substeps: physics steps a control tick are multiplied by this.
        variants: terms whose structure `model` has, and vectors u (mi, n) of their parameters; m
            is the sum of mi.
        wanted: of each sample its recording in the schedule, the index in `sample_ticks` of the
            tick at or before it, the fraction of a period since, and its joint; (k,) each.
        velocity: return that too, likewise.
    """
    with blaming(_taking_part(variants), "to simulate it"):
        q, dq, period = _run(model, joints, schedule, substeps, variants, threads)
    recording, tick, rest, joint = wanted
    first = (slice(None), recording, tick, joint)
    second = (slice(None), recording, tick + 1, joint)
    between = _hermite(rest, period, q[first], q[second], dq[first], dq[second])
    if not velocity:
        return (between,)
    return between, (1 - rest) * dq[first] + rest * dq[second]


def _taking_part(variants: Sequence[tuple[Layout, np.ndarray]]) -> list[Effect]:
    return [term.effect for layout, _ in variants for term in layout.terms]


def _run(
    model, joints, schedule, substeps, variants, threads
) -> tuple[np.ndarray, np.ndarray, float]:
    """Position and velocity of every variant, and the period from tick to tick, s."""
    m = sum(len(u) for _, u in variants)
    loop = ServoLoop(model, joints, schedule, m, threads, substeps)
    at = 0
    for layout, u in variants:
        simulations = loop.rows(slice(at, at + len(u)))
        values = layout.decode(u)
        for term in layout.terms:
            per_row = {k: loop.per_row(v) for k, v in values[term.effect.name].items()}
            term.effect.install(loop, simulations, np.array(term.joints, int), per_row)
        at += len(u)
    return *loop.run(), loop.period_s


def _hermite(part, period, q0, q1, v0, v1) -> np.ndarray:
    """Position at a part of the period between two ticks; exact under a held torque."""
    left, right = 1 - part, part
    return (
        (1 + 2 * right) * left**2 * q0
        + right**2 * (1 + 2 * left) * q1
        + period * (right * left**2 * v0 - right**2 * left * v1)
    )
