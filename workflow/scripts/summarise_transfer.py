"""Join the rollouts of all cells of a condition, and summarise each cell."""

import pandas as pd

from t2l.artefacts import read_table, write_table
from t2l.jobs import job
from t2l.rl.chosen import read_chosen
from t2l.transfer.errors import ROLLOUT_COLUMNS
from t2l.transfer.summary import cell_table

with job(snakemake):
    rollouts = [read_table(path, ROLLOUT_COLUMNS) for path in snakemake.input.rollouts]
    chosen = [read_chosen(path) for path in snakemake.input.chosen]
    write_table(pd.concat(rollouts, ignore_index=True), snakemake.output.rollouts)
    write_table(cell_table(rollouts, chosen), snakemake.output.cells)
