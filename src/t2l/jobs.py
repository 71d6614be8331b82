"""What every job of the workflow does around its one call: a log, and errors as messages."""

import contextlib
import logging
import os
import sys
import time
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NoReturn

from t2l.artefacts import set_aside
from t2l.errors import (
    ArtefactError,
    OutputError,
    T2LError,
    cannot_write,
    refused,
    writing,
)
from t2l.registry import load_extensions


class _Log(logging.FileHandler):
    """A log that says once why it cannot be written."""

    complained = False

    def handleError(self, record: logging.LogRecord) -> None:  # noqa: N802
        error = sys.exc_info()[1]
        if not isinstance(error, OSError):
            super().handleError(record)
        elif not self.complained:
            self.complained = True
            print(f"warning: {cannot_write(error, self.baseFilename)}", file=sys.stderr)

    def close(self) -> None:
        # what was not written for want of space is tried again here
        with contextlib.suppress(OSError):
            super().close()


@contextmanager
def job(snakemake: Any, markers: Sequence[Path | str] = ()) -> Iterator[None]:
    """Log, load extensions; an error that a person can mend ends the process with its message.

    A file that turns out to be broken is set aside: Snakemake misses it at the next run, and makes
    it anew.

    Args:
        snakemake: what Snakemake gives its scripts: the job's log and the configuration.
        markers: files that say that what Snakemake does not know of is complete; they are set
            aside with a broken file.
    """
    log_path = snakemake.log[0]
    try:
        with writing(log_path):
            Path(log_path).parent.mkdir(parents=True, exist_ok=True)
            handler = _Log(log_path, mode="w")
    except OutputError as error:
        sys.exit(f"error: {error}")
    handler.setFormatter(logging.Formatter("%(asctime)s %(message)s", datefmt="%H:%M:%S"))
    logging.basicConfig(level=logging.WARNING, handlers=[handler], force=True)
    logger = logging.getLogger("t2l")
    logger.setLevel(logging.INFO)
    start = time.monotonic()
    try:
        load_extensions(snakemake.config.get("extensions", []))
        yield
    except ArtefactError as error:
        _end(logger, _mended(error, markers))
    except T2LError as error:
        _end(logger, str(error))
    except OSError as error:
        if not refused(error):
            logger.error(traceback.format_exc())
            raise
        _end(logger, str(cannot_write(error, error.filename or Path.cwd())))
    except Exception:
        logger.error(traceback.format_exc())
        raise
    logger.info("done in %.1f s", time.monotonic() - start)


def _end(logger: logging.Logger, message: str) -> NoReturn:
    logger.error("error: %s", message)
    sys.exit(f"error: {message}")


def _mended(error: ArtefactError, markers: Sequence[Path | str]) -> str:
    """What is wrong with a file, and what has become of it."""
    broken = [path for path in (error.path, *map(Path, markers)) if os.path.lexists(path)]
    if error.path not in broken:
        return str(error)
    try:
        aside, *_ = [set_aside(path) for path in dict.fromkeys(broken)]
    except OutputError as refusal:
        return f"{error} It could not be set aside: {refusal}"
    return (
        f"{error.complaint}; set aside as {aside.name}; run again: it and what depends on it are "
        "made anew"
    )
