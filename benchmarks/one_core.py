"""Workers with a core each: what they run would otherwise take a thread for every core."""

import os
from multiprocessing.queues import SimpleQueue as BetweenProcesses
from queue import SimpleQueue as BetweenThreads

Queue = BetweenProcesses | BetweenThreads


def cores(queue: Queue) -> Queue:
    """`queue` with the cores of this process, for `take`."""
    for core in sorted(os.sched_getaffinity(0)):
        queue.put(core)
    return queue


def take(queue: Queue) -> None:
    """Keep this worker, and what it starts, to a core that no other has; it is an initializer."""
    os.sched_setaffinity(0, {queue.get()})
