"""Write how the cells of our tasks are ordered beside the study's own, as CSV, Markdown, LaTeX."""

from t2l.artefacts import read_table
from t2l.jobs import job
from t2l.stats.text import write_printed
from t2l.study.published.grids import read_grids
from t2l.study.published.order import (
    COLUMNS,
    printable_published_grids,
    published_grids_table,
)

with job(snakemake):
    kinds = snakemake.params.kinds
    cells = {
        task: read_table(path, COLUMNS)
        for task, path in zip(kinds, snakemake.input.cells, strict=True)
    }
    (published,) = snakemake.input.published
    table = published_grids_table(cells, kinds, read_grids(published))
    write_printed(table, printable_published_grids(table), snakemake.output)
