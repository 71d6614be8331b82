"""What every job of the workflow does around its one call: a log, and errors as messages."""

import fcntl
import logging
import os
import sys
import time
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from t2l.errors import T2LError


class AlreadyRunningError(T2LError):
    """Another run works in the same folder."""


def claim(folder: Path | str) -> int:
    """Claim `folder` for this process until it ends, however it ends; a file descriptor.

    Snakemake's own lock outlives a run that was killed; the kernel drops this one.

    Raises:
        AlreadyRunningError: another process has it.
    """
    path = Path(folder) / ".t2l_running"
    path.parent.mkdir(parents=True, exist_ok=True)
    descriptor = os.open(path, os.O_RDWR | os.O_CREAT)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(descriptor)
        raise AlreadyRunningError(
            f"{folder}: another run is at work here; wait for it or stop it first"
        ) from None
    return descriptor


@contextmanager
def job(log_path: Path | str) -> Iterator[None]:
    """Log to `log_path`; a `T2LError` ends the process with its message alone."""
    handler = logging.FileHandler(log_path, mode="w")
    handler.setFormatter(logging.Formatter("%(asctime)s %(message)s", datefmt="%H:%M:%S"))
    logging.basicConfig(level=logging.WARNING, handlers=[handler], force=True)
    logger = logging.getLogger("t2l")
    logger.setLevel(logging.INFO)
    start = time.monotonic()
    try:
        yield
    except T2LError as error:
        logger.error("error: %s", error)
        sys.exit(f"error: {error}")
    except Exception:
        logger.error(traceback.format_exc())
        raise
    logger.info("done in %.1f s", time.monotonic() - start)
