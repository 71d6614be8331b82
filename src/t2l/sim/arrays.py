"""Arrays of NumPy, or of torch on another device: one code for both.

What computes with the states of many simulations takes its functions from `namespace(array)`, the
array API standard, and its constants from `like`. So it runs wherever the simulations do.
"""

from typing import Any

import numpy as np
from array_api_compat import array_namespace as namespace
from array_api_compat import device

# of either kind; the array API has no type of its own
Array = Any

__all__ = ["Array", "columns", "like", "namespace", "to_numpy"]


def like(values: Array, array: Array) -> Array:
    """`values` where `array` is, in its precision; truth values stay so."""
    if type(values) is type(array):
        return values
    xp, values = namespace(array), np.asarray(values)
    kind = xp.bool if values.dtype == bool else array.dtype
    return xp.asarray(values, dtype=kind, device=device(array))


def columns(ids: np.ndarray) -> np.ndarray | slice:
    """Indices, as a slice where they are consecutive: another device takes one without a copy."""
    consecutive = ids.size > 0 and (np.diff(ids) == 1).all()
    return slice(int(ids[0]), int(ids[-1]) + 1) if consecutive else ids


def to_numpy(array: Array) -> np.ndarray:
    """A NumPy array of what may lie on another device."""
    return array if isinstance(array, np.ndarray) else array.detach().cpu().numpy()
