"""Put the cells of one task and variant into one table of rollouts and one of cells."""

from t2l.artefacts import write_table
from t2l.bc.summary import summarise
from t2l.jobs import job

with job(snakemake):
    given, seeds = snakemake.input, snakemake.params.seeds
    # one table of replays a cell, whatever the number of its policies
    replays = [path for path in given.replays for _ in seeds]
    rollouts, cells = summarise(
        replays, given.losses, given.rollouts, snakemake.params.demonstrations
    )
    write_table(rollouts, snakemake.output.rollouts)
    write_table(cells, snakemake.output.cells)
