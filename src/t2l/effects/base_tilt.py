"""A base that does not stand as the model says."""

import numpy as np

from t2l.effects.effect import Effect, Parameter

MOST_RAD = 1.2  # bound: nearer to a right angle, another mounting should be in the MJCF


class BaseTilt(Effect):
    """g → Ry(−pitch) Rx(−roll) g, in the frame of the base, which turns by Rx(roll) Ry(pitch)."""

    name = "base_tilt"
    title = "base tilt"
    parameters = tuple(
        Parameter(
            angle, "rad", -MOST_RAD, MOST_RAD, f"turn of the base about {axis} of the MJCF's world",
            per_joint=False, size=0.02,
        )
        for angle, axis in (("roll", "x"), ("pitch", "y"))
    )  # fmt: skip
    summary = "the base leans, so that gravity pulls in another direction than the model thinks"
    signature = "the error follows the gravity load as it would be for a leaning robot"
    source = "Newton-Euler with another gravity; MuJoCo, XML reference, option/gravity"
    remembers = False
    follows = "gravity"

    def export(self, to, joints, values):
        to.other_weight.append(self.name)
        gravity = np.array(to.spec.option.gravity)[None]
        to.spec.option.gravity = _turned(gravity, values["roll"], values["pitch"])[0]

    def install(self, loop, rows, joints, values):
        loop.inertia_changed = True  # MuJoCo asks for it after any option
        gravity = loop.batch.expand("opt.gravity")
        gravity[rows] = _turned(gravity[rows], values["roll"][:, 0], values["pitch"][:, 0])
        loop.other_weight[rows] = True

    def starts(self, scales):
        return [
            {"roll": np.array([roll]), "pitch": np.array([pitch])}
            for size in (0.03, 0.3)
            for roll, pitch in ((size, 0.0), (-size, 0.0), (0.0, size), (0.0, -size))
        ]


def _turned(gravity: np.ndarray, roll, pitch) -> np.ndarray:
    """(n, 3) as the base sees it, from (n, 3) without tilt."""
    x, y, z = gravity.T
    y, z = np.cos(roll) * y + np.sin(roll) * z, np.cos(roll) * z - np.sin(roll) * y
    x, z = np.cos(pitch) * x - np.sin(pitch) * z, np.cos(pitch) * z + np.sin(pitch) * x
    return np.stack(np.broadcast_arrays(x, y, z), axis=1)
