"""Compare what could tell the success of cloned policies, in our cells and in the study's."""

from t2l.artefacts import read_table
from t2l.gains import Grid
from t2l.jobs import job
from t2l.plotting.style import write
from t2l.stats.text import write_printed
from t2l.study.attenuation.figures import success
from t2l.study.attenuation.statistics import effective_error_table, printable_effective_error
from t2l.study.attenuation.success import COLUMNS, by_cell, predictors
from t2l.study.published.grids import read_grids

with job(snakemake):
    params = snakemake.params
    hold_s = 1 / params.rate_hz
    grids = {
        task: by_cell(read_table(path, COLUMNS))
        for task, path in zip(params.tasks, snakemake.input.cells, strict=True)
    }
    for path in snakemake.input.get("published", []):
        for name, cells in read_grids(path).items():
            grids[f"study: {name}"] = cells.assign(seeds=1)
    table = effective_error_table(grids, hold_s)
    write_printed(table, printable_effective_error(table), snakemake.output.table)
    shown = {name: predictors(cells, hold_s) for name, cells in grids.items()}
    write(success(shown, table, Grid.from_section(params.grid)), snakemake.output.figure)
