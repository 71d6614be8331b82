"""What a change of the model does to the positions of recordings, by the linear model of the loop.

A change is a variant of the model: an effect more, or another value of a parameter. Its torque
along the measured motion, less that of the model so far, goes through the linearised loop.
"""

from collections.abc import Sequence
from dataclasses import replace

import mujoco
import numpy as np

from t2l.detective.linear_loop import STEP_RAD, Section
from t2l.detective.paths import Variants, added_by_bodies, with_both
from t2l.detective.transmissions import added_through, rotors_of, through
from t2l.effects.blame import blaming
from t2l.effects.term import Layout
from t2l.identify.prediction import Predictor
from t2l.identify.simulation import install
from t2l.sim.driven_loop import DrivenLoop, Path, all_at_once

STIFF = 400  # numerics: ticks that the stiffness of a loop is the mean of
ROWS = 12_000  # numerics: ticks of variants that one call computes: arrays that a cache holds


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
    so_far = base[0], base[1][None]
    schedule, poses = section.motion.group.schedule, section.poses
    found: dict[int, np.ndarray] = {}
    remembering: dict[int, list[int]] = {}
    bodies = [added_by_bodies(predictor, schedule, poses, so_far, one) for one in variants]
    known: dict[tuple, np.ndarray] = {}
    base_remembers = any(term.effect.remembers for term in base[0].terms)
    for i, (layout, u) in enumerate(variants):
        model = with_both(predictor, so_far, layout)
        beyond = _beyond(predictor, section, model, base, variants[i])
        only_bodies = beyond is not None and beyond.changes_only_bodies()
        # what dry friction holds depends on these
        if only_bodies and not _installed(predictor, section, model, so_far).rubs:
            found[i] = _whole(bodies[i], section, len(u))
            continue
        plain, less, motor = variants[i], so_far, None
        fresh = not any(t.effect.remembers for t in layout.terms if t not in base[0].terms)
        if base_remembers and fresh and beyond is not None and beyond.acts_after_motor():
            motor = section.motor_torque(predictor, base)
        if motor is not None:
            plain, less = _forgetting(variants[i]), _forgetting(so_far)
        elif any(term.effect.remembers for term in (*base[0].terms, *layout.terms)):
            remembering.setdefault(id(model), []).append(i)
            continue
        key = id(model), motor is None
        if key not in known:
            known[key] = _at_once(predictor, section, model, less, motor=motor)
        found[i] = _at_once(predictor, section, model, plain, bodies[i], known[key], motor)
    for alike in remembering.values():
        some = [variants[i] for i in alike]
        moved = [_whole(bodies[i], section, len(variants[i][1])) for i in alike]
        found |= zip(alike, _in_turn(predictor, section, so_far, some, moved), strict=True)
    added = [found[i] for i in range(len(variants))]
    if not any(t.effect.extends for layout, _ in (so_far, *variants) for t in layout.terms):
        return added
    before = so_far, _as_one(predictor, section, section.path, base)
    return added_through(
        predictor, schedule, section.path, section.links, before, variants, added, bodies
    )


def excess(predictor: Predictor, section: Section, base: tuple[Layout, np.ndarray]) -> np.ndarray:
    """N·m (ntick, nrec, n) that a model u (n,) puts on the joints beyond what the motion takes.

    Less the same along its own prediction, where what is left is of the ticks alone.
    """
    found, schedule = [], section.motion.group.schedule
    rotors = rotors_of(predictor, schedule, (base[0], base[1][None]))
    for path in (section.path, section.predicted):
        one = _as_one(predictor, section, path, base)
        if rotors is not None:
            one = through(rotors, schedule, path, section.links, one[:, None])[:, 0]
        found.append(one)
    measured, predicted = found
    return measured - predicted


def _as_one(
    predictor: Predictor, section: Section, path: Path, base: tuple[Layout, np.ndarray]
) -> np.ndarray:
    """Beyond what a motion takes, (ntick, nrec, n), where motors and links are one."""
    layout, u = base
    model, schedule = predictor.model(layout.terms), section.motion.group.schedule
    loop = DrivenLoop(model, predictor.joints, schedule, 1)
    with blaming([term.effect for term in layout.terms], "to lead it"):
        install(loop, [(layout, u[None])])
        return loop.torque(path)[:, 0] - path.taken


def stiffness(
    predictor: Predictor, section: Section, variants: Sequence[Variants]
) -> list[np.ndarray]:
    """N·m/rad (m, n) of variants, on average over some ticks; joints turn together.

    What remembers is left out, as it would need the ticks in order.
    """
    path, schedule = section.path, section.motion.group.schedule
    ntick, nrec = path.q.shape[:2]
    ticks = np.arange(0, ntick * nrec, max(1, ntick * nrec // STIFF))
    k, twice = len(ticks), np.concatenate([ticks, ticks])
    some_ticks = all_at_once(schedule, ntick).of(twice)
    along = replace(path, holds=False).all_at_once().of(twice)
    along.q[:, k:] += STEP_RAD
    found = []
    for layout, u in variants:
        kept = Layout([term for term in layout.terms if not term.effect.remembers])
        at = [i for i, slot in enumerate(layout.slots) if not slot.term.effect.remembers]
        loop = DrivenLoop(predictor.model(kept.terms), predictor.joints, some_ticks, len(u))
        with blaming([term.effect for term in kept.terms], "to lead it"):
            install(loop, [(kept, u[:, at])])
            torque = loop.torque(along)[0]
        found.append((torque[:, :k] - torque[:, k:]).mean(axis=1) / STEP_RAD)
    return found


def _whole(torque: np.ndarray | float, section: Section, m: int) -> np.ndarray:
    """(ntick, m, nrec, njoint), of what may be zero."""
    if np.ndim(torque):
        return torque
    ntick, nrec, n = section.path.q.shape
    return np.zeros((ntick, m, nrec, n), np.float32)


def _in_turn(
    predictor: Predictor,
    section: Section,
    so_far: Variants,
    variants: Sequence[Variants],
    bodies: Sequence[np.ndarray],
) -> list[np.ndarray]:
    """Tick by tick, all in one loop."""
    model = with_both(predictor, so_far, variants[0][0])
    counts = [len(u) for _, u in variants]
    schedule = section.motion.group.schedule
    loop = DrivenLoop(model, predictor.joints, schedule, 1 + sum(counts))
    whole = [so_far, *variants]
    moved = np.concatenate([np.zeros_like(bodies[0][:, :1]), *bodies], axis=1)
    with blaming([t.effect for layout, _ in whole for t in layout.terms], "to lead it"):
        install(loop, whole)
        torque = loop.torque(section.path, moved)
    parts = np.split(torque[:, 1:] - torque[:, :1], np.cumsum(counts)[:-1], axis=1)
    return [part.astype(np.float32) for part in parts]


def _at_once(
    predictor: Predictor,
    section: Section,
    model: mujoco.MjModel,
    variants: Variants,
    bodies: np.ndarray | float = 0.0,
    less: np.ndarray | None = None,
    motor: np.ndarray | None = None,
) -> np.ndarray:
    """Ticks in no order, many in one call, (ntick, m, nrec, njoint).

    Args:
        less: of the model so far, which is taken off.
        motor: N·m (ntick, nrec, njoint) of the motor, where it is known.
    """
    path, schedule = section.path, section.motion.group.schedule
    layout, u = variants
    ntick, nrec, n = path.q.shape
    flat, whole = all_at_once(schedule, ntick), path.all_at_once()
    every = ntick * nrec
    size, width = max(1, ROWS // every), min(ROWS, every)
    out = np.empty((len(u), every, n), np.float64 if less is None else np.float32)
    own = 0.0 if less is None else less.reshape(every, n)
    given = None if motor is None else motor.reshape(1, every, n)
    moved = np.moveaxis(bodies, 1, 0).reshape(out.shape) if np.ndim(bodies) else None
    for begin in range(0, every, width):
        ticks = np.arange(begin, min(begin + width, every))
        some_ticks, along = flat.of(ticks), whole.of(ticks)
        reached = None if given is None else given[:, ticks]
        for first in range(0, len(u), size):
            some = slice(first, first + size)
            loop = DrivenLoop(model, predictor.joints, some_ticks, len(u[some]))
            more = None if moved is None else moved[None, some, ticks]
            with blaming([term.effect for term in layout.terms], "to lead it"):
                install(loop, [(layout, u[some])])
                torque = loop.torque(along, more, reached)[0]
            out[some, begin : begin + width] = torque - (own if less is None else own[ticks])
    return out.reshape(len(u), ntick, nrec, n).swapaxes(0, 1)


def _beyond(
    predictor, section: Section, model, base: tuple[Layout, np.ndarray], variants: Variants
) -> DrivenLoop | None:
    """A loop of what variants have beyond the model so far; None if they change or lack some."""
    layout, u = variants
    old = {slot.key: value for slot, value in zip(base[0].slots, base[1], strict=True)}
    kept = [i for i, slot in enumerate(layout.slots) if slot.key in old]
    if set(base[0].terms) - set(layout.terms):
        return None
    if any((u[:, i] != old[layout.slots[i].key]).any() for i in kept):
        return None
    more = Layout([term for term in layout.terms if term not in base[0].terms])
    own = {slot.key: i for i, slot in enumerate(layout.slots)}
    at = [own[slot.key] for slot in more.slots]
    return _installed(predictor, section, model, (more, u[:, at]))


def _forgetting(variants: Variants) -> Variants:
    """Without the terms that remember."""
    layout, u = variants
    kept = [i for i, slot in enumerate(layout.slots) if not slot.term.effect.remembers]
    return Layout([term for term in layout.terms if not term.effect.remembers]), u[:, kept]


def _installed(predictor, section: Section, model, variants: Variants) -> DrivenLoop:
    loop = DrivenLoop(model, predictor.joints, section.motion.group.schedule, len(variants[1]))
    with blaming([term.effect for term in variants[0].terms], "to lead it"):
        install(loop, [variants])
    return loop
