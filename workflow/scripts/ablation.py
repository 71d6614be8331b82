"""Tell and draw what each effect of the robot does to the policies of chosen cells."""

import pandas as pd

from t2l.artefacts import read_table
from t2l.figures.ablation import ablation
from t2l.gains import Grid
from t2l.jobs import job
from t2l.plotting.style import write
from t2l.stats.ablation import COLUMNS, WHOLE, ablation_table, by_cell, printable_ablation
from t2l.stats.text import write_printed

with job(snakemake):
    given, output = snakemake.input, snakemake.output
    grid = Grid.from_section(snakemake.params.grid)
    rollouts = {
        name: pd.concat([read_table(path, COLUMNS) for path in given[key]], ignore_index=True)
        for name, key in {WHOLE: "whole", **snakemake.params.effects}.items()
    }
    cells = by_cell(rollouts)
    inside = {
        cell: grid.region(cell) == "SO"
        for cell in grid.cells
        if ((cells.kp == cell.kp) & (cells.kd == cell.kd)).any()
    }
    table = ablation_table(cells, inside)
    write_printed(table, printable_ablation(table), output.table)
    write(ablation(cells, inside), output.figure)
