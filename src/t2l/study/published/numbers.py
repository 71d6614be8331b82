"""The study's numbers by claim (Bronars, Park and Agrawal, arXiv 2604.02523, and its page)."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from math import nan

import numpy as np
import pandas as pd
import yaml

from t2l.gains import Grid

REGIONS = ("CO", "CU", "SO", "SU")  # in its order; see `Split.regions`


@dataclass(frozen=True)
class Published:
    """What the study says about a claim.

    Attributes:
        section: of the paper.
        theirs: its numbers as a person reads them.
        values: those that a rule of ours compares with.
        note: what does not add up in the paper, or how far ours differs.
        number: whether it states one.
    """

    section: str
    theirs: str
    values: Mapping[str, float] = field(default_factory=dict)
    note: str = ""
    number: bool = True

    @property
    def effect(self) -> float:
        """The size of what is claimed, in the rule's unit; NaN where the study has no number."""
        return self.values.get("effect", nan)


@dataclass(frozen=True)
class Split:
    """Where the study divides a grid of gains: N·m/rad and N·m·s/rad."""

    compliant_up_to_kp: float
    overdamped_from_kd: float

    def regions(self, kp: np.ndarray, kd: np.ndarray) -> np.ndarray:
        """(n,) two letters a cell: C or S (compliant, stiff), then U or O (under-, overdamped)."""
        stiffness = np.where(np.asarray(kp) <= self.compliant_up_to_kp, "C", "S")
        damping = np.where(np.asarray(kd) >= self.overdamped_from_kd, "O", "U")
        return np.char.add(stiffness, damping)


@cache
def claims() -> dict[str, Published]:
    """By the key of a claim."""
    return {key: Published(**entry) for key, entry in _content()["claims"].items()}


@cache
def splits() -> dict[str, Split]:
    """Of behaviour cloning and of transfer."""
    return {key: Split(**entry) for key, entry in _content()["splits"].items()}


def grid_of(table: pd.DataFrame, chain: str) -> Grid:
    """The gains of a table, divided as the study divides those of `cloning` or `transfer`."""
    split = splits()[chain]
    kp, kd = (tuple(sorted(table[gain].unique())) for gain in ("kp", "kd"))
    return Grid(kp, kd, split.compliant_up_to_kp, split.overdamped_from_kd)


@cache
def _content() -> dict:
    return yaml.safe_load(
        (files("t2l.study.published") / "numbers.yaml").read_text(encoding="utf-8")
    )
