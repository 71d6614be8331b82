"""Torques that come through transmissions which give, along the motion that encoders show.

What gives between motor and link has a side that no encoder sees. Along the measured motion of the
other side it is a mass on a spring, so a model with it leaves as little as it should.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from t2l.detective.paths import Variants
from t2l.effects.term import Layout
from t2l.identify.prediction import Predictor
from t2l.identify.simulation import install
from t2l.sim.driven_loop import DrivenLoop, Path
from t2l.sim.schedule import Schedule
from t2l.sim.transmission import Transmission, hidden_acceleration


@dataclass(frozen=True)
class Rotors:
    """Of variants of a plant that give.

    Attributes:
        give: (m, nrec, n).
        inertia: (m, nrec, n) kg·m²; `more`, (n,), of that beyond the plant that does not give.
    """

    give: Transmission
    inertia: np.ndarray
    more: np.ndarray


def rotors(predictor: Predictor, schedule: Schedule, variants: Variants) -> Rotors | None:
    """Of layouts u (m, n); None if nothing gives in them."""
    layout, u = variants
    if not any(term.effect.extends for term in layout.terms):
        return None
    model, plain = predictor.model(layout.terms), predictor.model()
    loop = DrivenLoop(model, predictor.joints, schedule, len(u))
    install(loop, [variants])
    if not loop.transmission.gives.any():
        return None
    shape = (len(u), len(schedule.kp), len(predictor.joints))
    flat = loop.transmission
    give = Transmission(
        *(x.reshape(shape) for x in (flat.stiffness, flat.damping, flat.play, flat.on_link))
    )
    own, less = (
        one.dof_armature[[one.joint(name).dofadr[0] for name in predictor.joints]]
        for one in (model, plain)
    )
    return Rotors(give, (own + loop.added_armature()).reshape(shape), own - less)


def through(
    rotors: Rotors, schedule: Schedule, path: Path, mass: np.ndarray, excess: np.ndarray,
    bodies: np.ndarray | float = 0.0,
) -> np.ndarray:  # fmt: skip
    """N·m (ntick, m, nrec, n) beyond what the motion takes, of variants that give.

    Args:
        mass: (ntick, nrec, n, n) of links.
        excess: the same if they did not give.
        bodies: N·m likewise that other masses than the path's add.
    """
    link = path.link[:, None] - bodies
    found = excess - rotors.more * path.ddq[:, None]
    give = rotors.give
    on_link = give.on_link > 0.5
    total = found.copy()
    for at_link in (False, True):
        # joints that give alike are followed together
        side = give.gives & (on_link == at_link)
        patterns = {tuple(np.flatnonzero(row)) for row in side.any(axis=1)} - {()}
        for joints in patterns:
            some = [i for i, row in enumerate(side.any(axis=1)) if tuple(np.flatnonzero(row)) == joints]
            j = list(joints)
            own = give.of(some)
            own = Transmission(own.stiffness[..., j], own.damping[..., j], own.play[..., j], own.on_link[..., j])
            if at_link:
                inertia = rotors.inertia[some][..., j, None] * np.eye(len(j))
                pushed = np.broadcast_to(link, found.shape)[:, some][..., j] + found[:, some][..., j]
                ddq = hidden_acceleration(own, inertia[None].repeat(len(link), 0), pushed, schedule.period_s)
                for a, joint in enumerate(j):
                    total[:, some, :, joint] -= (rotors.inertia[some][..., joint] * ddq[..., a])
            else:
                inertia = mass[:, None][..., j, :][..., j]
                pushed = np.broadcast_to(link, found.shape)[:, some][..., j]
                ddq = hidden_acceleration(own, inertia, pushed, schedule.period_s)
                total[:, some] += np.einsum("trij,tmrj->tmri", mass[..., j], ddq)
    return total
