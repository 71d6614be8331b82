"""Count the trials that pass at the corners, and draw training with them."""

import pandas as pd

from t2l.artefacts import read_table
from t2l.gains import Cell, Grid
from t2l.jobs import job
from t2l.plotting.style import write
from t2l.stats.text import write_printed
from t2l.study.landscape.again import COLUMNS, CURVE_COLUMNS, no_curve
from t2l.study.landscape.figures import sample_efficiency
from t2l.study.landscape.statistics import Searched, landscape_table, printable_landscape

with job(snakemake):
    given, params, output = snakemake.input, snakemake.params, snakemake.output
    grid, section = Grid.from_section(params.grid), params.landscape
    each = len(given.again) // len(given.trials)
    searched = []
    for i, (condition, cell) in enumerate(params.searched):
        again = [read_table(path, CURVE_COLUMNS) for path in given.again[i * each : (i + 1) * each]]
        known = [table for table in again if len(table)] or [no_curve()]
        trials = read_table(given.trials[i], COLUMNS)
        searched.append(Searched(condition, Cell.from_name(cell), trials, pd.concat(known)))
    table = landscape_table(searched, grid, section["passed"], section["exists"])
    write_printed(table, printable_landscape(table), output.table)
    first = [one.again for one in searched if one.condition == searched[0].condition]
    known = [table for table in first if len(table)] or [no_curve()]
    write(sample_efficiency(pd.concat(known), grid), output.figure)
