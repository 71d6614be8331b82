"""Success by region of gains for every task and variant, as a table and a figure."""

from t2l.artefacts import read_table
from t2l.figures.variants import variants
from t2l.gains import Grid
from t2l.jobs import job
from t2l.plotting.style import write
from t2l.stats.regions import COLUMNS, printable_regions, region_table
from t2l.stats.text import write_printed

with job(snakemake):
    params, output = snakemake.params, snakemake.output
    cells = {
        name: read_table(path, COLUMNS)
        for name, path in zip(params.names, snakemake.input, strict=True)
    }
    table = region_table(cells, Grid.from_section(params.grid))
    write_printed(table, printable_regions(table), output.table)
    write(variants(table), output.figure)
