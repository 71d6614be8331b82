"""Gain cells, grids of them, and the regions a grid is split into."""

from t2l.gains.cell import Cell
from t2l.gains.grid import Grid, corner_regions

__all__ = ["Cell", "Grid", "corner_regions"]
