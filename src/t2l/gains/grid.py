"""A rectangular grid of cells and its compliant, overdamped part."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any

from t2l.gains.cell import Cell


@dataclass(frozen=True)
class Grid:
    """Every pair of the given gains, split into regions.

    Attributes:
        kp: ascending stiffnesses, N·m/rad.
        kd: ascending dampings, N·m·s/rad.
        compliant_up_to_kp: the largest stiffness that counts as compliant.
        overdamped_from_kd: the smallest damping that counts as overdamped.
        subset: which of the pairs are cells: `all`, or `corners_and_centre`.
    """

    kp: tuple[float, ...]
    kd: tuple[float, ...]
    compliant_up_to_kp: float
    overdamped_from_kd: float
    subset: str = "all"

    @classmethod
    def from_section(cls, section: Mapping[str, Any]) -> "Grid":
        """The grid that a `grid` section of a checked configuration describes."""
        return cls(**{**section, "kp": tuple(section["kp"]), "kd": tuple(section["kd"])})

    @property
    def cells(self) -> list[Cell]:
        """All cells, by Kd upward, then by Kp."""
        pairs = [Cell(kp=kp, kd=kd) for kd, kp in product(self.kd, self.kp)]
        if self.subset == "all":
            return pairs
        chosen = {*self.corners, self.centre}
        return [cell for cell in pairs if cell in chosen]

    @property
    def corners(self) -> list[Cell]:
        """The four extreme cells: CU, SU, CO, SO."""
        kps, kds = (self.kp[0], self.kp[-1]), (self.kd[0], self.kd[-1])
        return list(dict.fromkeys(Cell(kp=kp, kd=kd) for kd, kp in product(kds, kps)))

    @property
    def opposites(self) -> list[Cell]:
        """The most compliant, overdamped cell, and the stiffest, underdamped one."""
        co, su = Cell(kp=self.kp[0], kd=self.kd[-1]), Cell(kp=self.kp[-1], kd=self.kd[0])
        return list(dict.fromkeys((co, su)))

    @property
    def centre(self) -> Cell:
        """The cell in the middle, the lower one where a side is even."""
        return Cell(kp=self.kp[(len(self.kp) - 1) // 2], kd=self.kd[(len(self.kd) - 1) // 2])

    def in_compliant_overdamped(self, cell: Cell) -> bool:
        """Whether the cell belongs to G^CO."""
        return cell.kp <= self.compliant_up_to_kp and cell.kd >= self.overdamped_from_kd

    def region(self, cell: Cell) -> str:
        """Two letters: C or S (compliant, stiff), then U or O (under-, overdamped)."""
        stiffness = "C" if cell.kp <= self.compliant_up_to_kp else "S"
        damping = "O" if cell.kd >= self.overdamped_from_kd else "U"
        return stiffness + damping


def corner_regions(cells: Iterable[Cell]) -> dict[Cell, str]:
    """The region of each of four cells that are the corners of a grid; of others nothing.

    Stiff and overdamped are the higher gains of these four, whatever a gain is: of a robot that
    states its own, it is a factor.
    """
    cells = set(cells)
    kps, kds = {cell.kp for cell in cells}, {cell.kd for cell in cells}
    if not len(cells) == 4 == 2 * len(kps) == 2 * len(kds):
        return {}
    return {
        cell: ("S" if cell.kp == max(kps) else "C") + ("O" if cell.kd == max(kds) else "U")
        for cell in cells
    }
