"""Tests of t2l, in the folders of the library."""

from t2l.threads import one_thread

# tests run side by side, and so do their jobs: threads of linear algebra would wait for each other
one_thread()
