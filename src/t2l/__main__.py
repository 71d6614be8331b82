"""``t2l``, as a command and as ``python -m t2l``."""

import os


def main() -> None:
    """Run the command with one thread of linear algebra: its small matrices gain nothing by more.

    Libraries read the variables when they are loaded, so this comes before any import of them.
    """
    for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(variable, "1")
    from t2l.cli.main import main as run

    run()


if __name__ == "__main__":
    main()
