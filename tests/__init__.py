"""Tests of t2l, in the folders of the library."""

import os

# tests run side by side, and so do their jobs: threads of linear algebra would wait for each other
for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(name, "1")
