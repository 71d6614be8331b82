"""The cells that a checked configuration asks for."""

from t2l.config.models import Configuration
from t2l.config.models.cloning import Fidelity
from t2l.config.models.grid import Grid as GridSection
from t2l.gains import Cell, Grid


def grid_of(section: GridSection) -> Grid:
    """The grid that a section describes."""
    return Grid.from_section(section.model_dump())


def fidelity_cells(section: Fidelity) -> tuple[Cell, ...]:
    """The cells that retargeting is validated at."""
    return tuple(Cell(kp, kd) for kd in section.kd for kp in section.kp)


def transfer_cells(configuration: Configuration) -> tuple[Cell, ...]:
    """The cells of the recording grid that are run."""
    grid = grid_of(configuration.recording_grid)
    if configuration.sim_to_real.cells == "all":
        return tuple(grid.cells)
    chosen = {*grid.corners, grid.centre}
    return tuple(cell for cell in grid.cells if cell in chosen)
