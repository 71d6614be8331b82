"""Whether Optuna could open a storage, as far as can be told without a connection."""

import os
import re
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

from t2l.documents import open_regular
from t2l.errors import InputError
from t2l.rl.settings import JOURNAL
from t2l.typed import Problem, describe

if TYPE_CHECKING:
    import sqlalchemy

# how every file of SQLite 3 begins, and tables by which Optuna's are known
SQLITE, TABLES = b"SQLite format 3\0", {"studies", "version_info"}
OTHER = "a file that is there and is no database of Optuna's"
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
    found = _no_database(url) if url.get_backend_name() == "sqlite" else None
    return [Problem("tuning.storage", found, ALLOWED)] if found else []


def _no_database(url: "sqlalchemy.URL") -> str | None:
    """Why a file is not one that Optuna may write: it is another's, or none could be made there."""
    if url.database in (None, "", ":memory:"):
        return "a database in memory, which no other job sees"
    if url.query or url.database.startswith("file:"):
        return f"{describe(url.database)} with options of SQLite"
    path = Path(url.database)
    if not path.parent.is_dir():
        return f"a file in {path.parent}, which is no folder"
    # SQLite writes its own journal beside it
    if not os.access(path.parent, os.W_OK):
        return f"a file in {path.parent}, where nothing can be written"
    if not os.path.lexists(path):
        return None
    try:
        with open_regular(path) as file:
            first = file.read(len(SQLITE))
        # a run that was killed at once leaves an empty one
        return None if not first or (first == SQLITE and _is_optunas(path)) else f"{path}, {OTHER}"
    except InputError as error:
        return f"{path}, {error.found}"
    except (OSError, sqlite3.Error) as error:
        return f"{path}, which cannot be read ({error})"


def _is_optunas(path: Path) -> bool:
    """Whether an SQLite database has Optuna's tables, or none; it is not written."""
    with closing(sqlite3.connect(f"{path.absolute().as_uri()}?mode=ro", uri=True)) as database:
        names = {name for (name,) in database.execute("SELECT name FROM sqlite_master")}
    return not names or names >= TABLES


def _hidden(text: str) -> str:
    """A text with the user and password of URLs in it left out."""
    return re.sub(r"//[^@/\s]*@", "//…@", text)
