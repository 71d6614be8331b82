"""What is done, what remains, and an estimate of how long it takes."""

from collections import Counter, defaultdict
from collections.abc import Mapping


class Progress:
    """Progress of one run.

    Args:
        jobs: how many jobs each rule has.
        now: the time the run starts at, in seconds.
    """

    def __init__(self, jobs: Mapping[str, int], now: float):
        self._remaining = Counter(jobs)
        self._total = sum(jobs.values())
        self._start = now
        self._running: dict[int, tuple[str, str, float]] = {}
        self._seconds: dict[str, list[float]] = defaultdict(list)

    def plan(self) -> str:
        """One line: the jobs there are to run."""
        parts = ", ".join(f"{count} {rule}" for rule, count in self._remaining.items())
        return f"{self._total} jobs: {parts}"

    def started(self, job: int, rule: str, wildcards: Mapping[str, str], now: float) -> None:
        """Take note of a job."""
        self._running[job] = (rule, " ".join([rule, *map(str, wildcards.values())]), now)

    def failed(self, job: int) -> None:
        """Forget a job that will not finish."""
        self._running.pop(job, None)

    def finished(self, job: int, now: float, rule: str | None = None) -> str | None:
        """The line to show for a job that is done.

        A cluster's executor does not say when a job starts: then `rule` is all there is to show.
        """
        if job in self._running:
            rule, name, began = self._running.pop(job)
            self._seconds[rule].append(now - began)
            name = f"{name}  {duration(now - began)}"
        elif rule in self._remaining:
            name = rule
        else:
            return None
        self._remaining[rule] -= 1
        done = self._total - sum(self._remaining.values())
        width = len(str(self._total))
        line = f"{done:>{width}} of {self._total}  {name}"
        left = self.seconds_left(now)
        return line if left is None else f"{line}; about {duration(left)} left"

    def seconds_left(self, now: float) -> float | None:
        """Estimate from the mean time of each rule's jobs and how many ran side by side so far.

        A rule that has not run yet counts as the mean of all jobs. None at the end, and at the
        beginning: while fewer than a quarter of the jobs are done and most of those that remain
        are of such rules.
        """
        spent = sum(map(sum, self._seconds.values()))
        jobs = sum(map(len, self._seconds.values()))
        left = sum(self._remaining.values())
        known = sum(count for rule, count in self._remaining.items() if rule in self._seconds)
        guess = jobs < self._total / 4 and known < left / 2
        if not spent or not left or guess:
            return None
        work = -sum(now - began for *_, began in self._running.values())
        for rule, count in self._remaining.items():
            seconds = self._seconds.get(rule)
            work += count * (sum(seconds) / len(seconds) if seconds else spent / jobs)
        running = sum(now - began for *_, began in self._running.values())
        side_by_side = max(1.0, (spent + running) / max(now - self._start, 1e-9))
        return max(0.0, work) / side_by_side


def duration(seconds: float) -> str:
    """Seconds as a person says them."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    if seconds < 5400:
        return f"{seconds / 60:.0f} min"
    return f"{seconds / 3600:.1f} h"
