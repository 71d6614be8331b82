"""How many threads the libraries of a process may start."""

import os


def one_thread() -> None:
    """Give linear algebra and rendering one thread, unless their variables say otherwise.

    Here matrices are small, and processes run side by side. Libraries read the variables when they
    are loaded, so this comes before any import of them, or holds for processes started later.
    """
    for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(variable, "1")
    # of Mesa's renderer: none beside the process's own, which is faster too for small pictures
    os.environ.setdefault("LP_NUM_THREADS", "0")
