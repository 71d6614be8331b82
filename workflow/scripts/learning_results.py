"""How often policies succeed that were learned in simulation alone, and how they were learned."""

import pandas as pd

from t2l.artefacts import read_table, write_table
from t2l.figures.learned_tasks import COLUMNS as CURVE_COLUMNS
from t2l.figures.learned_tasks import learned_tasks
from t2l.jobs import job
from t2l.plotting.style import write
from t2l.rl.alone import COLUMNS
from t2l.stats import learning
from t2l.stats.text import write_printed

with job(snakemake):
    given, params, output = snakemake.input, snakemake.params, snakemake.output
    outcomes = [read_table(path, COLUMNS) for path in given.outcomes]
    policies = pd.concat(outcomes, ignore_index=True)
    write_table(policies, output.policies)
    table = learning.learning_table(policies)
    write_printed(table, learning.printable(table), output.table, learning.HEADERS)
    curves = {}
    for task, path in zip(params.tasks, given.trainings, strict=True):
        curves.setdefault(task, []).append(read_table(path, CURVE_COLUMNS))
    write(learned_tasks({task: pd.concat(each) for task, each in curves.items()}), output.figure)
