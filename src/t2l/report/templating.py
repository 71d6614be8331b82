"""Pages from templates."""

from collections.abc import Callable, Mapping

from jinja2 import Environment, PackageLoader, StrictUndefined


def templates(filters: Mapping[str, Callable]) -> Environment:
    """Templates in which every value is escaped, since recordings and effects name themselves."""
    environment = Environment(
        loader=PackageLoader("t2l.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= filters
    return environment
