"""Whether Optuna could open a storage, as far as can be told without a connection."""

import re
from pathlib import Path

from t2l.rl.settings import JOURNAL
from t2l.typed import Problem, describe

ALLOWED = (
    f"{JOURNAL}, or the URL of a database whose driver is installed, such as sqlite:///FILE.db"
)


def problems(storage: str) -> list[Problem]:
    """What is wrong with `tuning.storage`: nothing, or one thing, without its password."""
    if storage == JOURNAL:
        return []
    # slow to import, and most studies have a journal
    import sqlalchemy

    try:
        url = sqlalchemy.make_url(storage)
        url.get_dialect().import_dbapi()
    # each driver fails in ways of its own
    except Exception as error:
        reason = " ".join(_hidden(str(error)).split())[:200]
        found = f"{describe(_hidden(storage))} ({reason})"
        return [Problem("tuning.storage", found, ALLOWED)]
    folder = Path(url.database or ".").parent
    if url.get_backend_name() == "sqlite" and not folder.is_dir():
        return [Problem("tuning.storage", f"a file in {folder}, which is no folder", ALLOWED)]
    return []


def _hidden(text: str) -> str:
    """A text with the user and password of URLs in it left out."""
    return re.sub(r"//[^@/\s]*@", "//…@", text)
