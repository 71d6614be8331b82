"""Workers with cores of their own: what they run would otherwise take a thread for every core."""

import argparse
import multiprocessing
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing.queues import SimpleQueue as BetweenProcesses
from queue import SimpleQueue as BetweenThreads

Queue = BetweenProcesses | BetweenThreads


def cores(queue: Queue) -> Queue:
    """`queue` with the cores of this process, for `take`."""
    for core in sorted(os.sched_getaffinity(0)):
        queue.put({core})
    return queue


def first() -> set[int]:
    """One core of this process."""
    return {min(os.sched_getaffinity(0))}


def shares(queue: Queue, workers: int) -> Queue:
    """`queue` with an equal share of the cores of this process for each worker, for `take`."""
    own = sorted(os.sched_getaffinity(0))
    each = max(1, len(own) // workers)
    for first in range(0, each * workers, each):
        queue.put(set(own[first : first + each]))
    return queue


def take(queue: Queue) -> None:
    """Keep this worker, and what it starts, to cores that no other has; it is an initializer."""
    os.sched_setaffinity(0, queue.get())


def add_processes(parser: argparse.ArgumentParser, default: int) -> None:
    """--processes, alike in every benchmark that takes some."""
    most = len(os.sched_getaffinity(0))
    parser.add_argument(
        "--processes", type=int, default=default, choices=range(1, most + 1),
        metavar="N", help=f"at once, one to {most}: each takes a core",
    )  # fmt: skip


def each(function: Callable, items: Sequence, processes: int) -> Iterator:
    """`function` of every item, in their order, in processes with a core each."""
    # spawned, so that its linear algebra keeps to one thread
    os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"))
    context = multiprocessing.get_context("spawn")
    ready = cores(context.SimpleQueue())
    with ProcessPoolExecutor(processes, context, take, (ready,)) as pool:
        yield from pool.map(function, items)
