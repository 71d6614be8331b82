"""Torques that come through transmissions which give, along the motion that encoders show.

Motors and links are one in a plant that is led along a motion. Where a spring or play lies between,
one of them is hidden from the encoder, and what reaches the other is computed from its motion.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from t2l.detective.paths import Variants
from t2l.effects.blame import blaming
from t2l.identify.prediction import Predictor
from t2l.identify.simulation import install
from t2l.sim.driven_loop import DrivenLoop, Path
from t2l.sim.schedule import Schedule
from t2l.sim.transmission import Transmission, hidden_motion

# numerics: of the link's inertia, a rotor's: what has none would be anywhere within the play
LIGHTEST = 1e-3
NUMBERS = 20_000_000  # numerics: of torques that are followed at once


@dataclass(frozen=True)
class Links:
    """Of a plant along a motion, rotors left out; (ntick, nrec, n, n) each.

    Attributes:
        mass: kg·m².
        by_q: N·m/rad, derivatives of what the motion takes of them: mostly of their weight.
        felt: of that what motors feel: not the weight that is cancelled where the links are.
    """

    mass: np.ndarray
    by_q: np.ndarray
    felt: np.ndarray


@dataclass(frozen=True)
class Rotors:
    """Of m variants of a plant.

    Attributes:
        gives: (m, nrec, n).
        inertia: (m, nrec, n) kg·m².
        more: (m, 1, n) kg·m², of that what the plant has only where it gives.
    """

    gives: Transmission
    inertia: np.ndarray
    more: np.ndarray

    @classmethod
    def together(cls, some: Sequence["Rotors"]) -> "Rotors":
        """Of several layouts' variants."""
        return cls(
            Transmission.together([one.gives for one in some]),
            np.concatenate([one.inertia for one in some]),
            np.concatenate([one.more for one in some]),
        )


def rotors_of(predictor: Predictor, schedule: Schedule, variants: Variants) -> Rotors | None:
    """Of variants u (m, n) of a layout; None if nothing gives in them."""
    layout, u = variants
    if not any(term.effect.extends for term in layout.terms):
        return None
    model, joints = predictor.model(layout.terms), predictor.joints
    loop = DrivenLoop(model, joints, schedule, len(u))
    with blaming([term.effect for term in layout.terms], "to lead it"):
        install(loop, [variants])
    if not loop.transmission.gives.any():
        return None
    shape = (len(u), len(schedule.kp), len(joints))
    own, plain = (
        one.dof_armature[[one.joint(name).dofadr[0] for name in joints]]
        for one in (model, predictor.model())
    )
    inertia = (own + loop.added_armature()).reshape(shape)
    more = np.broadcast_to(own - plain, (len(u), 1, len(joints)))
    return Rotors(loop.transmission.reshaped(shape), inertia, more)


def through(
    rotors: Rotors,
    schedule: Schedule,
    path: Path,
    links: Links,
    excess: np.ndarray,
    bodies: np.ndarray | float = 0.0,
) -> np.ndarray:
    """N·m (ntick, m, nrec, n) of variants that give, beyond what the motion takes.

    Args:
        links: along the motion.
        excess: the same where motors and links are one.
        bodies: N·m likewise that other masses than the path's add.
    """
    found = excess - rotors.more * path.ddq[:, None]
    link = np.broadcast_to(path.link[:, None] - bodies, found.shape)
    out = found.copy()
    gives, on_link = rotors.gives.gives.any(axis=1), (rotors.gives.on_link > 0.5).any(axis=1)
    m, nrec, _ = rotors.inertia.shape
    # of which as many joints give they are followed together, links and rotors alike
    sides = np.concatenate([gives & ~on_link, gives & on_link])
    counts = sides.sum(axis=1)
    for count in np.unique(counts[counts > 0]):
        rows = np.flatnonzero(counts == count)
        joints, of = np.nonzero(sides[rows])[1].reshape(-1, 1, count), rows % m
        at = of[:, None, None], np.arange(nrec)[:, None], joints
        rotor = rows >= m
        push = link[:, *at]
        push[:, rotor] += found[:, *at][:, rotor]
        # by each joint that gives, of each other
        coupled, pulled, felt = (
            one.swapaxes(-1, -2)[:, at[1], joints] for one in (links.mass, links.by_q, links.felt)
        )
        own = joints[None, ..., None, :]
        inertia, weight = (
            np.take_along_axis(one, own, axis=-1).swapaxes(-1, -2) for one in (coupled, pulled)
        )
        carried = np.diagonal(inertia[:1, rotor], axis1=-2, axis2=-1)[0]
        turned = np.maximum(rotors.inertia[at][rotor], LIGHTEST * carried)
        inertia[:, rotor], weight[:, rotor] = turned[..., None] * np.eye(count), 0.0
        ddq, lag = hidden_motion(rotors.gives.of(at), inertia, push, schedule.period_s, weight)
        for by, moved in ((coupled, ddq), (felt, lag)):
            out[:, of[~rotor]] += np.einsum("tmrjn,tmrj->tmrn", by[:, ~rotor], moved[:, ~rotor])
        behind = of[rotor, None, None], at[1], joints[rotor]
        out[:, *behind] -= rotors.inertia[behind] * ddq[:, rotor]
    return out


def added_through(
    predictor: Predictor,
    schedule: Schedule,
    path: Path,
    links: Links,
    so_far: tuple[Variants, np.ndarray],
    variants: Sequence[Variants],
    added: list[np.ndarray],
    bodies: Sequence[np.ndarray | float],
) -> list[np.ndarray]:
    """What variants add to the model so far, N·m (ntick, m, nrec, n) each.

    Args:
        so_far: the model, u (1, n), and what it has beyond what the motion takes, (ntick, nrec, n)
            N·m, where motors and links are one.
        added: the same where they are one; `bodies`, of that of other masses.
    """
    (base, before), found = so_far, dict(enumerate(added))
    whole = [rotors_of(predictor, schedule, one) for one in (base, *variants)]
    if not any(whole):
        return added
    less, before = 0.0, before[:, None]
    if whole[0]:
        less = through(whole[0], schedule, path, links, before) - before
        rigid = (i for i, rotors in enumerate(whole[1:]) if rotors is None)
        found |= {i: added[i] - less for i in rigid}
    own = [
        i for i, rotors in enumerate(whole[1:])
        if rotors is not None and not (whole[0] and _add_nothing(whole[0], rotors, bodies[i]))
    ]  # fmt: skip
    for some in _chunks([len(variants[i][1]) for i in own], max(1, NUMBERS // before.size)):
        alike = [own[i] for i in some]
        excess = np.concatenate([before + added[i] for i in alike], axis=1)
        moved = [np.broadcast_to(bodies[i], added[i].shape) for i in alike]
        rotors = Rotors.together([whole[1 + i] for i in alike])
        ways = through(rotors, schedule, path, links, excess, np.concatenate(moved, axis=1))
        counts = np.cumsum([len(variants[i][1]) for i in alike])[:-1]
        found |= zip(alike, np.split(ways - before - less, counts, axis=1), strict=True)
    return [found[i].astype(np.float32, copy=False) for i in range(len(added))]


def _add_nothing(base: Rotors, rotors: Rotors, bodies: np.ndarray | float) -> bool:
    """Whether variants move hidden links as the model so far does."""
    shows_link = (rotors.gives.on_link * rotors.gives.gives).any()
    same = np.isscalar(bodies) and not shows_link and (rotors.more == base.more).all()
    return same and rotors.gives.is_as(base.gives)


def _chunks(counts: Sequence[int], most: int) -> Iterator[list[int]]:
    """Indices, of each chunk with so many in all, or one."""
    chunk: list[int] = []
    for i, count in enumerate(counts):
        if chunk and sum(counts[k] for k in chunk) + count > most:
            yield chunk
            chunk = []
        chunk.append(i)
    if chunk:
        yield chunk
