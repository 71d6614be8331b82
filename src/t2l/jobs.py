"""What every job of the workflow does around its one call: a log, and errors as messages."""

import logging
import sys
import time
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from t2l.errors import T2LError


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
