"""A trained policy as plain numbers: it acts without torch, in a simulator or on a robot."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from t2l.artefacts import read_npz, whole
from t2l.errors import ArtefactError

CLIPPED_AT = 10.0  # standard deviations of a normalised observation


@dataclass(frozen=True, eq=False)
class ReachPolicy:
    """The mean action of a Gaussian policy with ELU layers.

    Attributes:
        mean, deviation: (nobs,) of observations while training.
        weights, biases: of each layer, (nout, nin) and (nout,).
        action_scale: α of joints 1 to 4 and 5 to 7, rad.
    """

    mean: np.ndarray
    deviation: np.ndarray
    weights: tuple[np.ndarray, ...]
    biases: tuple[np.ndarray, ...]
    action_scale: tuple[float, float]

    def act(self, observation: np.ndarray) -> np.ndarray:
        """Actions (n, 7) in [-1, 1] for observations (n, nobs)."""
        x = (observation - self.mean) / self.deviation
        x = np.clip(x, -CLIPPED_AT, CLIPPED_AT)
        *hidden, last = zip(self.weights, self.biases, strict=True)
        for weight, bias in hidden:
            x = x @ weight.T + bias
            x = np.where(x > 0, x, np.expm1(np.minimum(x, 0)))
        return np.clip(x @ last[0].T + last[1], -1.0, 1.0)

    def save(self, path: Path | str) -> None:
        """Write an .npz file whole."""
        layers = {f"weight{i}": weight for i, weight in enumerate(self.weights)}
        layers |= {f"bias{i}": bias for i, bias in enumerate(self.biases)}
        with whole(path) as draft:
            np.savez(
                draft, mean=self.mean, deviation=self.deviation,
                action_scale=np.array(self.action_scale), **layers,
            )  # fmt: skip


def load(path: Path | str) -> ReachPolicy:
    """Read what `ReachPolicy.save` wrote.

    Raises:
        ArtefactError: it is not that, or its layers do not fit each other.
    """
    arrays = read_npz(path, ("mean", "deviation", "action_scale", "weight0", "bias0"))
    count = sum(name.startswith("weight") for name in arrays)
    layers = [(f"weight{i}", f"bias{i}") for i in range(count)]
    known = {"mean", "deviation", "action_scale", *(name for pair in layers for name in pair)}
    odd = sorted(known.symmetric_difference(arrays))
    expected = "a policy: mean, deviation, action_scale, and weight and bias of each layer"
    if odd:
        verb = "has no" if odd[0] in known else "has"
        raise ArtefactError(path, f"{verb} {odd[0]}", expected)
    for name, array in arrays.items():
        if array.dtype.kind != "f":
            raise ArtefactError(path, f"{name} holds {array.dtype}", "floating-point numbers")
    before, shapes = arrays["mean"].shape, {"action_scale": (2,)}
    shapes |= {"mean": before[:1], "deviation": before[:1]}
    for weight, bias in layers:
        after = arrays[weight].shape[:1]
        shapes |= {weight: after + before, bias: after}
        before = after
    for name, shape in shapes.items():
        if arrays[name].shape != shape:
            raise ArtefactError(path, f"{name} has shape {arrays[name].shape}", f"{shape}")
    proximal, distal = map(float, arrays["action_scale"])
    return ReachPolicy(
        mean=arrays["mean"],
        deviation=arrays["deviation"],
        weights=tuple(arrays[weight] for weight, _ in layers),
        biases=tuple(arrays[bias] for _, bias in layers),
        action_scale=(proximal, distal),
    )
