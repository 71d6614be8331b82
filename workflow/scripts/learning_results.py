"""How often policies succeed that were learned in simulation alone, and how they were learned."""

import pandas as pd

from t2l.artefacts import read_table, write_table, write_text
from t2l.figures.learned_tasks import COLUMNS as CURVE_COLUMNS
from t2l.figures.learned_tasks import learned_tasks
from t2l.jobs import job
from t2l.plotting.style import write
from t2l.rl.alone import COLUMNS
from t2l.stats import learning
from t2l.stats.text import latex

with job(snakemake):
    given, params, output = snakemake.input, snakemake.params, snakemake.output
    outcomes = [read_table(path, COLUMNS) for path in given.outcomes]
    policies = pd.concat(outcomes, ignore_index=True)
    write_table(policies, output.policies)
    table = learning.learning_table(policies)
    csv, markdown, tex = output.table
    printed = learning.printable(table)
    write_text(table.to_csv(index=False), csv)
    write_text(printed.to_markdown(index=False, disable_numparse=True) + "\n", markdown)
    write_text(latex(printed, learning.HEADERS), tex)
    curves = {}
    for task, path in zip(params.tasks, given.trainings, strict=True):
        curves.setdefault(task, []).append(read_table(path, CURVE_COLUMNS))
    write(learned_tasks({task: pd.concat(each) for task, each in curves.items()}), output.figure)
