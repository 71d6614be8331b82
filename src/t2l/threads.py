"""How many threads the libraries of a process may start."""

import os


def one_thread() -> None:
    """Give linear algebra one thread, unless its variables say otherwise.

    Here matrices are small, and processes run side by side. Libraries read the variables when they
    are loaded, so this comes before any import of them, or holds for processes started later.
    """
    for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(variable, "1")
