"""Draw S* over the grid, and measured against simulated motion."""

from t2l.artefacts import read_table
from t2l.figures.identification import CELL_COLUMNS, overlays, residual_error
from t2l.gains import Grid
from t2l.identify.artefacts import LOSS_COLUMNS, TRACE_COLUMNS
from t2l.jobs import job
from t2l.plotting.style import write

with job(snakemake):
    grid = Grid.from_section(snakemake.params.grid)
    cells = read_table(snakemake.input.cells, CELL_COLUMNS)
    losses = [read_table(path, LOSS_COLUMNS) for path in snakemake.input.losses]
    traces = [read_table(path, TRACE_COLUMNS) for path in snakemake.input.traces]
    figure = residual_error(cells, losses, grid, snakemake.params.gains)
    write(figure, snakemake.output.error)
    write(overlays(traces), snakemake.output.overlays)
