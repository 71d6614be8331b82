"""One fraction for a whole run, which never goes back, of however many steps it has."""

from collections.abc import Callable, Iterator

Progress = Callable[[str, float], None]


def part(progress: Progress, first: float, last: float) -> Progress:
    """Progress of a piece of work that is a part of the whole, from `first` to `last` of it."""
    return lambda what, fraction: progress(what, first + (last - first) * fraction)


def pieces(progress: Progress) -> Iterator[Progress]:
    """Progress of pieces of work whose number is not known: each takes half of what is left."""
    first = 0.0
    while True:
        last = (1 + first) / 2
        yield part(progress, first, last)
        first = last


def forward(progress: Progress) -> Progress:
    """The same, but a fraction never falls below one that was reported before."""
    reached = 0.0

    def report(what: str, fraction: float) -> None:
        nonlocal reached
        reached = max(reached, fraction)
        progress(what, reached)

    return report
