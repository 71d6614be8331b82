"""The tables that claims are judged by, and where in a study's results they lie."""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING

from t2l.artefacts import read_table

if TYPE_CHECKING:
    import pandas as pd

# by kind, below results/STUDY; the first that matches a path is its kind
PATTERNS = {
    "again": "sim_to_real/{condition}/{cell}/again/{configuration}_seed{seed}.parquet",
    "training": "sim_to_real/{condition}/{cell}/seed{seed}/training.parquet",
    "trials": "sim_to_real/{condition}/{cell}/trials.parquet",
    "transfer": "sim_to_real/{condition}/rollouts.parquet",
    "policies": "sim_to_real/{condition}/cells.parquet",
    "identification": "sim_to_real/identification.parquet",
    "learned": "learning/policies.parquet",
    "variance": "attenuation/held_noise.parquet",
    "following": "following/joints.parquet",
    "stiffness": "decoupling/trainings.parquet",
    "decision": "tables/transfer_decision_{condition}.csv",
    "noise": "{task}/noise/{cell}/noisy_replays.parquet",
    "fidelity": "{task}/fidelity/{cell}.parquet",
    "cloning": "{task}/{variant}/cells.parquet",
    # of the first collection; of the others
    "anew": "{task}/collection{number}/{variant}/cells.parquet",
}
_REGEX = {
    kind: re.compile(re.sub(r"\\\{(\w+)\\\}", r"(?P<\1>[^/]+)", re.escape(pattern)))
    for kind, pattern in PATTERNS.items()
}


class AbsentError(Exception):
    """A table that a claim needs is not there; the message says which."""


class AmbiguousError(Exception):
    """Several studies have what a claim needs; the message names them."""


@dataclass(frozen=True)
class Source:
    """A file of results: of which study and kind, with the names in its path, such as its task."""

    path: Path
    study: str
    kind: str
    fields: tuple[tuple[str, str], ...]


def source_of(path: Path | str) -> Source | None:
    """What a path such as results/STUDY/block_stack/nominal/cells.parquet holds, if any of it."""
    parts = PurePosixPath(path).parts
    if "results" not in parts[:-2]:
        return None
    at = len(parts) - 1 - parts[::-1].index("results")
    below = "/".join(parts[at + 2 :])
    for kind, regex in _REGEX.items():
        if match := regex.fullmatch(below):
            return Source(Path(path), parts[at + 1], kind, tuple(sorted(match.groupdict().items())))
    return None


def found_in(folder: Path | str) -> list[Path]:
    """The files below results/STUDY that claims may be judged by, in order of their names."""
    folder = Path(folder)
    globs = {re.sub(r"\{\w+\}", "*", pattern) for pattern in PATTERNS.values()}
    found = {path for glob in globs for path in folder.glob(glob)}
    return sorted(path for path in found if source_of(path))


class Evidence:
    """Tables by kind and by the names in their paths, of one study or of several.

    A table is one study's. Of several, `of_one` takes a study that has all that a claim needs.
    """

    def __init__(self, tables: Sequence[tuple[Source, "pd.DataFrame"]]):
        self._tables = tables

    @classmethod
    def read(cls, paths: Sequence[Path | str]) -> "Evidence":
        """Of those paths that hold something for a claim.

        Raises:
            ArtefactError: a file is missing, cut short or no table.
        """
        sources = [source for path in paths if (source := source_of(path))]
        return cls([(source, read_table(source.path, ())) for source in sources])

    @property
    def studies(self) -> list[str]:
        """Whose results were read, in their order."""
        return list(dict.fromkeys(source.study for source, _ in self._tables))

    def only(self, study: str) -> "Evidence":
        """What one study has."""
        return Evidence(
            [(source, table) for source, table in self._tables if source.study == study]
        )

    def of_one[Made](self, about: str, make: "Callable[[Evidence], Made]") -> Made:
        """What is made of the tables of one study, whatever the order in which they were read.

        Of the study `about` if they are there. If not, of the one other study that has them: under
        any name, so that a study of one's own counts too.

        Args:
            make: raises `AbsentError` for a study that has not all that it needs.

        Raises:
            AbsentError: of `about`, or the first by name, where no study has them.
            AmbiguousError: several others have them.
        """
        made, absent = {}, []
        for study in sorted(self.studies, key=lambda name: (name != about, name)):
            try:
                made[study] = make(self.only(study))
            except AbsentError as error:
                absent.append(error)
                continue
            if study == about:
                break
        if len(made) > 1:
            raise AmbiguousError(f"{' and '.join(made)} have it, and none of them is {about}")
        if not made:
            raise absent[0] if absent else AbsentError("no results")
        return next(iter(made.values()))

    def names(self, kind: str, field: str) -> list[str]:
        """What stands in the paths of a kind, such as the variants of cloning."""
        found = (dict(s.fields).get(field, "") for s, _ in self._tables if s.kind == kind)
        return list(dict.fromkeys(found))

    def table(self, kind: str, columns: Sequence[str], **fields: str) -> "pd.DataFrame":
        """All rows of a kind whose paths have the given names, with at least these columns.

        Raises:
            AbsentError: there is no such table with rows, or it lacks a column.
            AmbiguousError: several studies have one.
        """
        import pandas as pd

        called = " ".join([*fields.values(), kind])
        found = [
            (source.study, table)
            for source, table in self._tables
            if source.kind == kind and fields.items() <= dict(source.fields).items() and len(table)
        ]
        studies = sorted({study for study, _ in found})
        if len(studies) > 1:
            raise AmbiguousError(f"{' and '.join(studies)} have a table of {called}")
        if not found:
            raise AbsentError(f"no table of {called}")
        whole = pd.concat([table for _, table in found], ignore_index=True)
        lacking = [column for column in columns if column not in whole]
        if lacking:
            raise AbsentError(f"the table of {called} has no {', '.join(lacking)}")
        return whole
