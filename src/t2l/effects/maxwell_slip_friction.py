"""Friction and hysteresis of elements that stretch and slip one after the other."""

from itertools import combinations

import numpy as np

from t2l.effects.effect import Effect, Parameter
from t2l.effects.elements import LEAST, add_elements, install_elements

COUNT = 3  # bound: elements; measured motions rarely tell the bend of more
APART = 2.0  # guess: of one radius and the next
RADII = 20  # numerics: that are tried where radii are read off
NARROWEST = 2e-3  # numerics: of these, in parts of the range


class MaxwellSlipFriction(Effect):
    """τ = −Σ F_k z_k / r_k, ż_k = q̇ within |z_k| ≤ r_k, of three elements side by side."""

    name = "maxwell_slip_friction"
    title = "Maxwell-slip friction"
    parameters = tuple(
        one
        for k in range(1, COUNT + 1)
        for one in (
            Parameter(
                f"torque_{k}", "N·m", 0.0, 10.0, f"at which element {k} slips, F", scale="torque"
            ),
            Parameter(
                f"radius_{k}", "rad", 1e-4, 2.0, f"of motion until then, r of element {k}",
                log=True, scale="range",
            ),
        )
    )  # fmt: skip
    summary = "hysteresis of cables, seals or gears that stretch and slip bit by bit"
    signature = "the error follows the direction, and eases in bit by bit after each reversal"
    source = (
        "Iwan, A distributed-element model for hysteresis, 1966; Al-Bender, Lampaert and Swevers, "
        "The generalized Maxwell-slip model, 2005"
    )
    contains = ("coulomb_friction", "dahl_friction")
    follows = "direction"
    holds_torque = True
    reads = ("recording",)
    order = 50  # at the start elements hold what all other torques leave

    def export(self, to, joints, values):
        to.call(self.name, stretch_and_slip, joints, values)

    def held(self, values):
        torque, radii = of_elements(values)
        total = torque.sum(axis=-1)
        return total, (torque * radii).sum(axis=-1) / np.maximum(total, LEAST)

    def install(self, loop, rows, joints, values):
        install_elements(loop, rows, joints, *of_elements(values))

    def starts(self, scales):
        return [
            {
                f"{name}_{k + 1}": value
                for k in range(COUNT)
                for name, value in (
                    ("torque", f / COUNT * scales.torque),
                    ("radius", r * APART ** (k + 1 - COUNT) * scales.range),
                )
            }
            for f in (0.05, 0.5)
            for r in (0.03, 0.3)
        ]

    def read_off(self, q, torque, clock_s, recording):
        parts = [recording == r for r in np.unique(recording)]
        radii = np.ptp(q) * np.geomspace(NARROWEST, 1.0, RADII)
        if np.ptp(q) == 0:
            return None
        columns = np.concatenate([_stretches(q[at], radii) for at in parts])
        # what an element that never slips is off by at the start stays
        for at in parts:
            columns[at] -= columns[at].mean(axis=0)
        left = np.concatenate([torque[at] - torque[at].mean() for at in parts])
        levels, chosen = strongest_elements(columns, -left)
        values = {}
        for k in range(COUNT):
            values |= {f"torque_{k + 1}": levels[k], f"radius_{k + 1}": radii[chosen[k]]}
        return values


def strongest_elements(columns: np.ndarray, torque: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of columns (n, m) the few that explain a torque (n,) best with weights of at least zero.

    Returns:
        Weights and indices, (`COUNT`,) each.
    """
    gram, along = columns.T @ columns, columns.T @ torque
    best, levels, chosen = 0.0, np.zeros(COUNT), np.arange(COUNT)
    for count in range(1, COUNT + 1):
        sets = np.array(list(combinations(range(columns.shape[1]), count)))
        own = gram[sets[:, :, None], sets[:, None, :]]
        own = own + LEAST * np.trace(gram) * np.eye(count)
        weights = np.linalg.solve(own, along[sets][..., None])[..., 0]
        gain = np.where((weights >= 0).all(axis=1), (weights * along[sets]).sum(axis=1), 0.0)
        at = int(np.argmax(gain))
        if gain[at] > best:
            best = gain[at]
            rest = [i for i in range(COUNT) if i not in sets[at]][: COUNT - count]
            chosen = np.array([*sets[at], *rest])
            levels = np.array([*weights[at], *[0.0] * (COUNT - count)])
    return levels, chosen


def _stretches(q: np.ndarray, radii: np.ndarray) -> np.ndarray:
    """(n, m) of the elements of radii (m,), in parts of these, along q (n,) from none."""
    z, found = np.zeros(len(radii)), np.empty((len(q), len(radii)))
    for i, by in enumerate(np.diff(q, prepend=q[0])):
        z = found[i] = np.minimum(np.maximum(z + by, -radii), radii)
    return found / radii


def of_elements(values):
    """N·m at which elements slip, and their radii in rad, (…, k, `COUNT`) each."""
    torque, radii = [], []
    for k in range(1, COUNT + 1):
        torque.append(values[f"torque_{k}"])
        radii.append(values[f"radius_{k}"])
    return np.stack(torque, axis=-1), np.stack(radii, axis=-1)


def stretch_and_slip(robot, joints, values):
    """Add elements that slip one after the other."""
    torque, radii = of_elements(values)
    add_elements(robot, joints, torque, radii)
