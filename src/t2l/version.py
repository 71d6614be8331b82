"""Which library, and which extensions of it, a result was made by."""

import hashlib
from collections.abc import Sequence
from functools import cache
from importlib.metadata import version
from pathlib import Path

from t2l.registry import python_files


@cache
def library() -> str:
    """t2l's version and a digest of its sources, and MuJoCo's version.

    Two checkouts of one version may differ, so what is kept between runs says which it was.
    """
    digest = hashlib.sha256()
    home = Path(__file__).parent
    for path in sorted(home.rglob("*.py")):
        digest.update(str(path.relative_to(home)).encode())
        digest.update(path.read_bytes())
    return f"t2l {version('t2l')} {digest.hexdigest()[:16]}, mujoco {version('mujoco')}"


def with_extensions(extensions: Sequence[Path | str]) -> str:
    """t2l's version and, where there are extensions, a digest of their files.

    Args:
        extensions: Python files, or folders of them.
    """
    if not extensions:
        return version("t2l")
    digest = hashlib.sha256()
    for path in python_files(extensions):
        digest.update(path.read_bytes())
    return f"{version('t2l')} {digest.hexdigest()[:16]}"
