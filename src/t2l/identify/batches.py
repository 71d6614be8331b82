"""What one batch simulates and how many threads step it, so that no core waits."""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

MAX_SIMULATIONS = 1024  # numerics: in one batch; more gain nothing and cost memory
MAX_NUMBERS = 3e7  # numerics: recorded by one batch
LEAST_STEPS_PER_THREAD = 20  # numerics: of single joints a tick, for which another one pays
LEAST_DOFS_PER_BATCH = 400  # numerics: of its simulations together, to be run beside another one

Piece = tuple[int, int]  # a variant: which request, and which row of its u
Found = Sequence[list[np.ndarray]]


@dataclass(frozen=True)
class Job:
    """One batch: `call` simulates `pieces` at the samples `held`.

    Attributes:
        simulations: how many, which have `dofs` driven joints together.
        steps: of single joints that they take in `ticks` ticks.
    """

    call: Callable[..., tuple[np.ndarray, ...]]
    pieces: list[Piece]
    held: np.ndarray
    simulations: int
    dofs: int
    steps: int
    ticks: int

    def threads(self, most: int) -> int:
        """As many as pay."""
        paying = self.steps // (self.ticks * LEAST_STEPS_PER_THREAD)
        return max(1, min(most, self.simulations, paying))

    def run(self, outs: Found, threads: int) -> None:
        """Simulate, and put what is found into the arrays (m, nsample) of each request."""
        for found, out in zip(self.call(threads=threads), outs, strict=False):
            at = 0
            for i, rows in by_request(self.pieces):
                out[i][np.ix_(rows, self.held)] = found[at : at + len(rows)]
                at += len(rows)


class Progress:
    """Which part of the work of several jobs is done, told to `report`."""

    def __init__(self, report: Callable[[float], None]):
        self.report, self.steps, self.done = report, [], []

    def of(self, steps: int) -> Callable[[float], None]:
        """What the next job, of so many steps, calls with the part of its own work."""
        number = len(self.steps)
        self.steps.append(steps)
        self.done.append(0.0)

        def tell(part: float) -> None:
            self.done[number] = part * steps
            self.report(sum(self.done) / sum(self.steps))

        return tell


def run(jobs: Sequence[Job], outs: Found, threads: int) -> None:
    """All jobs: large ones side by side, small ones one after the other on all threads."""
    jobs = sorted(jobs, key=lambda job: -job.steps)
    large = [job for job in jobs if job.dofs >= LEAST_DOFS_PER_BATCH]
    small = [job for job in jobs if job.dofs < LEAST_DOFS_PER_BATCH]
    # while one computes torques another steps its physics
    each = max(1, threads // max(1, len(large)))
    with ThreadPoolExecutor(threads) as pool:
        done = [pool.submit(job.run, outs, job.threads(each)) for job in large]
        for future in done:
            future.result()
    for job in small:
        job.run(outs, job.threads(threads))


def chunks(pieces: list[Piece], dofs: int, numbers: int, recordings: int, share: int) -> list:
    """`pieces` in chunks that make a batch each: a thread's share, if that is worth a batch.

    Args:
        dofs: driven joints of a piece's simulations together.
        numbers: that one simulation records.
        recordings: simulations of a piece.
        share: pieces that keep one thread busy while others work on the rest.
    """
    simulations = min(MAX_SIMULATIONS, MAX_NUMBERS / numbers)
    largest = max(1, int(simulations // recordings))
    batches = max(1, min(-(-len(pieces) // share), len(pieces) * dofs // LEAST_DOFS_PER_BATCH))
    size = min(largest, -(-len(pieces) // batches))
    return [pieces[i : i + size] for i in range(0, len(pieces), size)]


def by_request(pieces: Sequence[Piece]) -> list[tuple[int, list[int]]]:
    """Requests of successive pieces, each with its rows."""
    requests: list[tuple[int, list[int]]] = []
    for request, row in pieces:
        if not requests or requests[-1][0] != request:
            requests.append((request, []))
        requests[-1][1].append(row)
    return requests
