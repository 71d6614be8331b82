"""What a change of the model does to the positions of recordings, by the linear model of the loop.

A change is a variant of the model: an effect more, or another value of a parameter. Its torque
along the measured motion, less that of the model so far, goes through the linearised loop.
"""

from collections.abc import Sequence

import mujoco
import numpy as np

from t2l.detective.linear_loop import Section
from t2l.effects.blame import blaming
from t2l.effects.term import Layout
from t2l.identify.prediction import Predictor
from t2l.identify.simulation import install
from t2l.sim.driven_loop import DrivenLoop, all_at_once

ROWS = 300_000  # numerics: ticks of variants that one call computes

Variants = tuple[Layout, np.ndarray]


def added_torques(
    predictor: Predictor,
    section: Section,
    base: tuple[Layout, np.ndarray],
    variants: Sequence[Variants],
) -> list[np.ndarray]:
    """N·m of variants (m, n) beyond those of the model so far, (ntick, m, nrec, njoint) each.

    Args:
        base: layout and parameters (n,) of the model so far.
        variants: layouts, each with the u (m, n) of its variants.
    """
    found: dict[int, np.ndarray] = {}
    remembering: dict[int, list[int]] = {}
    for i, (layout, u) in enumerate(variants):
        if any(term.effect.remembers for term in layout.terms):
            model = _with_both(predictor, base, layout)
            remembering.setdefault(id(model), []).append(i)
        else:
            found[i] = _at_once(predictor, section, base, layout, u)
    for alike in remembering.values():
        some = [variants[i] for i in alike]
        found |= zip(alike, _in_turn(predictor, section, base, some), strict=True)
    return [found[i] + _bodies(predictor, section, base, *v) for i, v in enumerate(variants)]


def _with_both(predictor: Predictor, base, layout: Layout) -> mujoco.MjModel:
    """The plant with what either adds to its structure: a variant may lack a term of the model."""
    names = {term.effect.name for term in layout.terms}
    lost = [term for term in base[0].terms if term.effect.name not in names]
    return predictor.model([*layout.terms, *lost])


def _in_turn(predictor, section: Section, base, variants: Sequence[Variants]) -> list[np.ndarray]:
    """Tick by tick, all in one loop."""
    model = _with_both(predictor, base, variants[0][0])
    counts = [len(u) for _, u in variants]
    schedule = section.motion.group.schedule
    loop = DrivenLoop(model, predictor.joints, schedule, 1 + sum(counts))
    whole = [(base[0], base[1][None]), *variants]
    with blaming([t.effect for layout, _ in whole for t in layout.terms], "to lead it"):
        install(loop, whole)
        torque = loop.torque(section.path)
    parts = np.split(torque[:, 1:] - torque[:, :1], np.cumsum(counts)[:-1], axis=1)
    return [part.astype(np.float32) for part in parts]


def _at_once(predictor, section: Section, base, layout: Layout, u: np.ndarray) -> np.ndarray:
    """All ticks in one call."""
    path, schedule = section.path, section.motion.group.schedule
    ntick, nrec, n = path.q.shape
    flat, whole = all_at_once(schedule, ntick), path.all_at_once()
    model, joints = _with_both(predictor, base, layout), predictor.joints
    size = max(1, ROWS // (ntick * nrec))
    parts = []
    for first in range(0, len(u), size):
        some = u[first : first + size]
        loop = DrivenLoop(model, joints, flat, len(some) + 1)
        with blaming([term.effect for term in layout.terms], "to lead it"):
            install(loop, [(base[0], base[1][None]), (layout, some)])
            torque = loop.torque(whole)[0]
        parts.append((torque[1:] - torque[:1]).astype(np.float32))
    return np.concatenate(parts).reshape(len(u), ntick, nrec, n).swapaxes(0, 1)


def _bodies(predictor, section: Section, base, layout: Layout, u: np.ndarray):
    """N·m that other masses or another gravity take away."""
    model = _with_both(predictor, base, layout)
    loop = DrivenLoop(model, predictor.joints, section.motion.group.schedule, len(u) + 1)
    install(loop, [(base[0], base[1][None]), (layout, u)])
    taken = loop.by_bodies(section.poses)
    if taken is None:
        return 0.0
    return -section.poses.at_ticks(taken[:, 1:] - taken[:, :1])
