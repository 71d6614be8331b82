"""Random generators derived from a base seed and the names of what they are for."""

import zlib

import numpy as np


def seed_sequence(base: int, *names: str | int) -> np.random.SeedSequence:
    """A seed that depends on `base` and on every name, in order, and on nothing else."""
    return np.random.SeedSequence([base, *(zlib.crc32(str(name).encode()) for name in names)])


def generator(base: int, *names: str | int) -> np.random.Generator:
    """A NumPy generator for the stage (and cell) that `names` spell."""
    return np.random.default_rng(seed_sequence(base, *names))


def torch_seed(base: int, *names: str | int) -> int:
    """A 63-bit seed for ``torch.manual_seed``."""
    return int(seed_sequence(base, *names).generate_state(1, np.uint64)[0] >> 1)
