"""Put the cells of one task into one table of rollouts and one of cells."""

from t2l.artefacts import write_table
from t2l.bc.summary import summarise
from t2l.jobs import job

with job(snakemake):
    rollouts, cells = summarise(
        snakemake.input.replays, snakemake.input.losses, snakemake.input.rollouts
    )
    write_table(rollouts, snakemake.output.rollouts)
    write_table(cells, snakemake.output.cells)
