"""Draw the trials of tuning, and training with what they chose."""

import pandas as pd

from t2l.artefacts import read_table
from t2l.figures.learning import CURVE_COLUMNS, TRIAL_COLUMNS, landscape, training_curves
from t2l.gains import Cell, Grid
from t2l.jobs import job
from t2l.plotting.style import write

with job(snakemake):
    given, params = snakemake.input, snakemake.params
    grid = Grid.from_section(params.grid)
    trials = {
        Cell.from_name(name): read_table(path, TRIAL_COLUMNS)
        for name, path in zip(params.cells, given.trials, strict=True)
    }
    write(landscape(trials, grid), snakemake.output.landscape)
    curves = {
        condition: pd.concat(
            [read_table(path, CURVE_COLUMNS) for path in given[f"training_{condition}"]],
            ignore_index=True,
        )
        for condition in params.conditions
    }
    write(training_curves(curves, grid), snakemake.output.training)
