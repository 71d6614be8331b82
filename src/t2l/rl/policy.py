"""A trained policy as plain numbers: it acts without torch, in a simulator or on a robot."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from t2l.artefacts import reading, whole

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
        ArtefactError: it is not that.
    """
    with reading(path, "policy", "a training job"), np.load(path, allow_pickle=False) as arrays:
        count = sum(name.startswith("weight") for name in arrays.files)
        return ReachPolicy(
            mean=arrays["mean"],
            deviation=arrays["deviation"],
            weights=tuple(arrays[f"weight{i}"] for i in range(count)),
            biases=tuple(arrays[f"bias{i}"] for i in range(count)),
            action_scale=tuple(float(scale) for scale in arrays["action_scale"]),
        )
