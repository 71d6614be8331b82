"""Which optional part of t2l brings a package that is not installed."""

import re
from importlib.metadata import PackageNotFoundError, requires


def extra_of(package: str) -> str | None:
    """The extra that brings a package, such as `robot` for aiofranka; None if none does.

    Args:
        package: name to import, with or without modules in it.
    """
    wanted = package.partition(".")[0].lower()
    try:
        requirements = requires("t2l") or []
    # run from a folder of sources, not installed
    except PackageNotFoundError:
        return None
    for requirement in requirements:
        name = re.match(r"[\w.-]+", requirement)[0].replace("-", "_").lower()
        extra = re.search(r"extra == ['\"](\w+)['\"]", requirement)
        if extra and name == wanted:
            return extra[1]
    return None
