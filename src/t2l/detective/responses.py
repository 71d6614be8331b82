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

ROWS = 12_000  # numerics: ticks of variants that one call computes: arrays that a cache holds

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
    found: dict[int, np.ndarray | float] = {}
    remembering: dict[int, list[int]] = {}
    so_far: dict[int, np.ndarray] = {}
    for i, (layout, u) in enumerate(variants):
        model = _with_both(predictor, base, layout)
        if _only_bodies(predictor, section, model, base, layout, u):
            found[i] = 0.0
        elif any(term.effect.remembers for term in (*base[0].terms, *layout.terms)):
            remembering.setdefault(id(model), []).append(i)
        else:
            if id(model) not in so_far:
                so_far[id(model)] = _at_once(predictor, section, model, base[0], base[1][None])
            found[i] = _at_once(predictor, section, model, layout, u, so_far[id(model)])
    for alike in remembering.values():
        some = [variants[i] for i in alike]
        found |= zip(alike, _in_turn(predictor, section, base, some), strict=True)
    return [
        _summed(found[i], _bodies(predictor, section, base, *one), section, len(one[1]))
        for i, one in enumerate(variants)
    ]


def _summed(loop, bodies, section: Section, m: int) -> np.ndarray:
    """(ntick, m, nrec, njoint), of parts of which each may be zero."""
    ntick, nrec, n = section.path.q.shape
    both = loop + bodies
    return both if np.ndim(both) else np.zeros((ntick, m, nrec, n), np.float32)


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


def _at_once(
    predictor,
    section: Section,
    model,
    layout: Layout,
    u: np.ndarray,
    so_far: np.ndarray | None = None,
) -> np.ndarray:
    """Ticks in no order, many in one call, beyond the model so far, (ntick, m, nrec, njoint)."""
    path, schedule = section.path, section.motion.group.schedule
    ntick, nrec, n = path.q.shape
    flat, whole = all_at_once(schedule, ntick), path.all_at_once()
    every = ntick * nrec
    size, width = max(1, ROWS // every), min(ROWS, every)
    out = np.empty((len(u), every, n), np.float64 if so_far is None else np.float32)
    less = 0.0 if so_far is None else so_far.reshape(every, n)
    for begin in range(0, every, width):
        ticks = np.arange(begin, min(begin + width, every))
        some_ticks, along = flat.of(ticks), whole.of(ticks)
        own = less if so_far is None else less[ticks]
        for first in range(0, len(u), size):
            some = u[first : first + size]
            loop = DrivenLoop(model, predictor.joints, some_ticks, len(some))
            with blaming([term.effect for term in layout.terms], "to lead it"):
                install(loop, [(layout, some)])
                torque = loop.torque(along)[0]
            out[first : first + size, begin : begin + width] = torque - own
    return out.reshape(len(u), ntick, nrec, n).swapaxes(0, 1)


def _only_bodies(predictor, section: Section, model, base, layout: Layout, u: np.ndarray) -> bool:
    """Whether variants (m, n) differ from the model so far by other bodies or gravity alone."""
    old = {slot.key: value for slot, value in zip(base[0].slots, base[1], strict=True)}
    kept = [i for i, slot in enumerate(layout.slots) if slot.key in old]
    if set(base[0].terms) - set(layout.terms):
        return False
    if any((u[:, i] != old[layout.slots[i].key]).any() for i in kept):
        return False
    loop = DrivenLoop(model, predictor.joints, section.motion.group.schedule, len(u))
    more = Layout([term for term in layout.terms if term not in base[0].terms])
    own = {slot.key: i for i, slot in enumerate(layout.slots)}
    with blaming([term.effect for term in more.terms], "to lead it"):
        install(loop, [(more, u[:, [own[slot.key] for slot in more.slots]])])
    return loop.changes_only_bodies()


def _bodies(predictor, section: Section, base, layout: Layout, u: np.ndarray):
    """N·m that other masses or another gravity take away."""
    model = _with_both(predictor, base, layout)
    loop = DrivenLoop(model, predictor.joints, section.motion.group.schedule, len(u) + 1)
    with blaming([term.effect for term in layout.terms], "to lead it"):
        install(loop, [(base[0], base[1][None]), (layout, u)])
    taken = loop.by_bodies(section.poses)
    if taken is None:
        return 0.0
    return section.poses.at_ticks((taken[:, :1] - taken[:, 1:]).astype(np.float32))
