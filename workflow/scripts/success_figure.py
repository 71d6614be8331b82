"""Draw success, validation loss and replay success over the grid."""

from t2l.artefacts import read_table
from t2l.figures.success import COLUMNS, replay_success, success_and_loss
from t2l.gains import Grid
from t2l.jobs import job
from t2l.plotting.style import title, write

with job(snakemake):
    grid = Grid.from_section(snakemake.params.grid)
    cells = read_table(snakemake.input.cells, COLUMNS)
    heading = title(snakemake.wildcards.task)
    write(
        success_and_loss(cells, grid, f"{heading}: behaviour cloning by controller gains"),
        snakemake.output.success,
    )
    write(
        replay_success(cells, grid, f"{heading}: replays of demonstrations"),
        snakemake.output.replay,
    )
