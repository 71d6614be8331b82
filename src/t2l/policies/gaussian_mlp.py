"""The policy `gaussian_mlp`: the mean of a Gaussian whose network has ELU layers, without torch."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field

from t2l.policies.policy import Policy
from t2l.typed import Number, Typed, check

CLIPPED_AT = 10.0  # standard deviations of a normalised observation


class Metadata(Typed):
    """What is no tensor."""

    action_scale: list[Annotated[Number, Field(gt=0)]]
    clipped: bool = True


@dataclass(frozen=True, eq=False)
class GaussianMLP(Policy):
    """Sees one observation and answers with one action.

    Attributes:
        mean, deviation: (nobs,) of observations while training.
        weights, biases: of each layer, (nout, nin) and (nout,).
        action_scale: (nact,) α.
        clipped: whether each element of an action is kept in [-1, 1].
    """

    mean: np.ndarray
    deviation: np.ndarray
    weights: tuple[np.ndarray, ...]
    biases: tuple[np.ndarray, ...]
    action_scale: np.ndarray
    clipped: bool = True

    name = "gaussian_mlp"
    history = 1
    chunk = 1

    @property
    def observation_size(self) -> int:
        """See `Policy`."""
        return len(self.mean)

    @property
    def action_size(self) -> int:
        """See `Policy`."""
        return len(self.biases[-1])

    def act(self, history: np.ndarray) -> np.ndarray:
        """See `Policy.act`."""
        x = (history[:, 0] - self.mean) / self.deviation
        x = np.clip(x, -CLIPPED_AT, CLIPPED_AT)
        *hidden, last = zip(self.weights, self.biases, strict=True)
        for weight, bias in hidden:
            x = x @ weight.T + bias
            x = np.where(x > 0, x, np.expm1(np.minimum(x, 0)))
        action = x @ last[0].T + last[1]
        return (np.clip(action, -1.0, 1.0) if self.clipped else action)[:, None]

    def tensors(self) -> dict[str, np.ndarray]:
        """See `Policy.tensors`."""
        layers = {f"weight{i}": weight for i, weight in enumerate(self.weights)}
        layers |= {f"bias{i}": bias for i, bias in enumerate(self.biases)}
        return {"mean": self.mean, "deviation": self.deviation, **layers}

    def metadata(self) -> dict[str, Any]:
        """See `Policy.metadata`."""
        return {"action_scale": self.action_scale.tolist(), "clipped": self.clipped}

    @classmethod
    def restored(cls, tensors: Mapping[str, np.ndarray], metadata: Mapping[str, Any]) -> Self:
        """See `Policy.restored`."""
        known_metadata = check(Metadata, metadata)
        scale = np.array(known_metadata.action_scale, float)
        count = sum(name.startswith("weight") for name in tensors)
        layers = [(f"weight{i}", f"bias{i}") for i in range(max(1, count))]
        known = {"mean", "deviation", *(name for pair in layers for name in pair)}
        if odd := sorted(known.symmetric_difference(tensors)):
            verb = "has no" if odd[0] in known else "has"
            raise ValueError(
                f"{verb} {odd[0]}; allowed: mean, deviation, weight and bias of each layer"
            )
        for name, array in tensors.items():
            if array.dtype.kind != "f":
                raise ValueError(f"{name} holds {array.dtype}, not floating-point numbers")
        before = tensors["mean"].shape[:1]
        shapes = {"mean": before, "deviation": before}
        for weight, bias in layers:
            after = tensors[weight].shape[:1]
            shapes |= {weight: after + before, bias: after}
            before = after
        shapes[layers[-1][1]] = scale.shape
        for name, shape in shapes.items():
            if tensors[name].shape != shape:
                raise ValueError(f"{name} has shape {tensors[name].shape}, not {shape}")
        return cls(
            mean=tensors["mean"],
            deviation=tensors["deviation"],
            weights=tuple(tensors[weight] for weight, _ in layers),
            biases=tuple(tensors[bias] for _, bias in layers),
            action_scale=scale,
            clipped=known_metadata.clipped,
        )
