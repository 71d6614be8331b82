"""A Snakemake logger that says, a line a job, what is done, what remains and how long it takes.

Snakemake finds it by its package name; `logger: t2l` in a profile selects it. Whatever is not
progress (errors, dry runs, "Nothing to be done") is shown as Snakemake shows it.

Snakemake imports this package before it reads any configuration file, so it is also where t2l's
loader of them is put in place.
"""

import re
import sys
from collections import Counter
from logging import LogRecord

from snakemake_interface_logger_plugins.base import LogHandlerBase
from snakemake_interface_logger_plugins.common import LogEvent

from snakemake_logger_plugin_t2l import configfiles
from snakemake_logger_plugin_t2l.progress import Progress

configfiles.install()

_SILENT = (
    LogEvent.WORKFLOW_STARTED,
    LogEvent.PROGRESS,
    LogEvent.JOB_STARTED,
    LogEvent.RESOURCES_INFO,
)
_CHATTER = (
    "Select jobs to execute",
    "Execute ",
    "Assuming unrestricted",
    "Using shell",
    "Conda env",
)


def _rule_of(message: str) -> str | None:
    """The rule that "Finished jobid: 3 (Rule: train)" names."""
    found = re.search(r"\(Rule: (\w+)\)", message)
    return found[1] if found else None


class LogHandler(LogHandlerBase):
    """Writes to the stream that Snakemake logs to."""

    def __post_init__(self) -> None:
        self._progress: Progress | None = None
        self._stream = sys.stdout if self.common_settings.stdout else sys.stderr

    def emit(self, record: LogRecord) -> None:
        text = self._text(record)
        if text:
            print(text, file=self._stream, flush=True)

    def _text(self, record: LogRecord) -> str | None:
        event = getattr(record, "event", None)
        if self.common_settings.dryrun:
            return self.format(record)
        if event == LogEvent.RUN_INFO:
            counts = Counter(record.stats)
            counts.pop("total", None)
            self._progress = Progress(counts, record.created)
            return self._progress.plan()
        if self._progress is not None:
            if event == LogEvent.JOB_INFO:
                self._progress.started(
                    *(record.jobid, record.rule_name, dict(record.wildcards), record.created)
                )
                return None
            if event == LogEvent.JOB_FINISHED:
                return self._progress.finished(
                    record.job_id, record.created, _rule_of(record.getMessage())
                )
            if event == LogEvent.JOB_ERROR:
                self._progress.failed(record.jobid)
        if event in _SILENT:
            return None
        text = self.format(record)
        return None if event is None and text.startswith(_CHATTER) else text

    @property
    def writes_to_stream(self) -> bool:
        """Takes the place of Snakemake's own messages."""
        return True

    @property
    def writes_to_file(self) -> bool:
        """Snakemake keeps its own log file."""
        return False

    @property
    def has_filter(self) -> bool:
        """Snakemake's own filter applies, so that --quiet means what it says."""
        return False

    @property
    def has_formatter(self) -> bool:
        """What is not progress looks as Snakemake formats it."""
        return False

    @property
    def needs_rulegraph(self) -> bool:
        """Counts of jobs are enough."""
        return False
