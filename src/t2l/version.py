"""Which library a result was made by."""

import hashlib
from functools import cache
from importlib.metadata import version
from pathlib import Path


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
