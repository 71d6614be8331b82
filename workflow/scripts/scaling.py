"""Success by region of gains and number of demonstrations, as a table and a figure."""

import pandas as pd

from t2l.artefacts import read_table
from t2l.figures.scaling import scaling
from t2l.gains import Grid
from t2l.jobs import job
from t2l.plotting.style import write
from t2l.stats.scaling import COLUMNS, printable_scaling, scaling_table
from t2l.stats.text import write_printed

with job(snakemake):
    params, output = snakemake.params, snakemake.output
    grid, tables = Grid.from_section(params.grid), {}
    for task in params.tasks:
        paths = snakemake.input[task]
        tables[task] = scaling_table(
            pd.concat([read_table(path, COLUMNS) for path in paths], ignore_index=True), grid
        )
    table = pd.concat([own.assign(task=task) for task, own in tables.items()], ignore_index=True)
    printed = [printable_scaling(own).assign(Task=task) for task, own in tables.items()]
    write_printed(table, pd.concat(printed, ignore_index=True), output.table)
    write(scaling(tables), output.figure)
