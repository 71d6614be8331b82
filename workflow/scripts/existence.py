"""Whether policies exist at the corners, of tasks that are learned in simulation alone."""

from t2l.artefacts import read_table
from t2l.gains import Cell
from t2l.jobs import job
from t2l.plotting.style import write
from t2l.rl.alone import COLUMNS
from t2l.stats.text import write_printed
from t2l.study.landscape.existence import at_corners, existence_table, printable_existence
from t2l.study.landscape.figures import existence

with job(snakemake):
    given, output = snakemake.input, snakemake.output
    cells = {
        task: [Cell.from_name(name) for name in names]
        for task, names in snakemake.params.cells.items()
    }
    table = existence_table(at_corners(read_table(given[0], COLUMNS), cells))
    write_printed(table, printable_existence(table), output.table)
    write(existence(table), output.figure)
