"""Join the rollouts of all policies of a condition, and summarise each policy."""

import pandas as pd

from t2l.artefacts import read_table, write_table
from t2l.jobs import job
from t2l.rl.results import read_chosen, read_outcome
from t2l.transfer.errors import ROLLOUT_COLUMNS
from t2l.transfer.summary import policy_row

with job(snakemake):
    given, seeds = snakemake.input, snakemake.params.seeds
    rollouts = [read_table(path, ROLLOUT_COLUMNS) for path in given.rollouts]
    outcomes = [read_outcome(path) for path in given.outcomes]
    # one choice for all seeds of a cell
    chosen = [read_chosen(path) for path in given.chosen for _ in range(seeds)]
    rows = [policy_row(*each) for each in zip(rollouts, chosen, outcomes, strict=True)]
    cells = pd.DataFrame(rows).sort_values(["kd", "kp", "seed"], ignore_index=True)
    write_table(pd.concat(rollouts, ignore_index=True), snakemake.output.rollouts)
    write_table(cells, snakemake.output.cells)
