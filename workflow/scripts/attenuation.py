"""Draw and tabulate the simulated variance under held noise beside theory."""

from t2l.artefacts import read_table
from t2l.gains import Grid
from t2l.jobs import job
from t2l.plotting.style import write
from t2l.stats.text import write_printed
from t2l.study.attenuation.figures import variance
from t2l.study.attenuation.rack import COLUMNS
from t2l.study.attenuation.statistics import printable_variance, variance_table

with job(snakemake):
    held = read_table(snakemake.input[0], COLUMNS)
    write(variance(held, Grid.from_section(snakemake.params.grid)), snakemake.output.figure)
    table = variance_table(held)
    write_printed(table, printable_variance(table), snakemake.output.table)
