"""Count the trials that pass at the corners, and draw training with them."""

import pandas as pd

from t2l.artefacts import read_table, write_text
from t2l.figures.sample_efficiency import sample_efficiency
from t2l.gains import Cell, Grid
from t2l.jobs import job
from t2l.plotting.style import write
from t2l.rl.landscape import COLUMNS, CURVE_COLUMNS, no_curve
from t2l.stats import landscape
from t2l.stats.text import latex

with job(snakemake):
    given, params, output = snakemake.input, snakemake.params, snakemake.output
    grid, section = Grid.from_section(params.grid), params.landscape
    each = len(given.again) // len(given.trials)
    searched = []
    for i, (condition, cell) in enumerate(params.searched):
        again = [read_table(path, CURVE_COLUMNS) for path in given.again[i * each : (i + 1) * each]]
        known = [table for table in again if len(table)] or [no_curve()]
        trials = read_table(given.trials[i], COLUMNS)
        searched.append(
            landscape.Searched(condition, Cell.from_name(cell), trials, pd.concat(known))
        )
    table = landscape.landscape_table(searched, grid, section["passed"], section["exists"])
    csv, markdown, tex = output.table
    printed = landscape.printable(table)
    write_text(table.to_csv(index=False), csv)
    write_text(printed.to_markdown(index=False, disable_numparse=True) + "\n", markdown)
    write_text(latex(printed, landscape.HEADERS), tex)
    first = [one.again for one in searched if one.condition == searched[0].condition]
    known = [table for table in first if len(table)] or [no_curve()]
    write(sample_efficiency(pd.concat(known), grid), output.figure)
