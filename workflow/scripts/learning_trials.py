"""How many trials succeed, of tasks that are learned in simulation alone."""

import pandas as pd

from t2l.artefacts import read_table
from t2l.jobs import job
from t2l.stats import learning
from t2l.stats.text import write_printed
from t2l.study.passing import PASSED

with job(snakemake):
    trials = [read_table(path, learning.TRIAL_COLUMNS) for path in snakemake.input]
    table = learning.trials_table(pd.concat(trials, ignore_index=True), PASSED)
    write_printed(table, learning.printable_trials(table), snakemake.output, learning.HEADERS)
