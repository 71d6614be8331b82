"""Tensors of a file against those of the network that they are for."""

from collections.abc import Mapping

import numpy as np
import torch
from torch import Tensor


def fitting(tensors: Mapping[str, np.ndarray], wanted: Mapping[str, Tensor]) -> dict[str, Tensor]:
    """`tensors` as a network's state.

    Args:
        wanted: the network's state; shapes and types alone, which may lie on the device `meta`.

    Raises:
        ValueError: one is missing, too many, or of another shape or type.
    """
    given = {name: torch.from_numpy(array) for name, array in tensors.items()}
    for name, tensor in wanted.items():
        found = given[name]
        if (found.shape, found.dtype) != (tensor.shape, tensor.dtype):
            raise ValueError(f"{name} is {found.dtype} of {tuple(found.shape)}, "
                             f"not {tensor.dtype} of {tuple(tensor.shape)}")  # fmt: skip
    if set(given) != set(wanted):
        raise ValueError("tensors that a network of its sizes does not have")
    return given
