"""Write the study's table as CSV, Markdown and LaTeX."""

from t2l.artefacts import read_table, write_text
from t2l.gains import Grid
from t2l.jobs import job
from t2l.stats.table import COLUMNS, behaviour_cloning_table, printable, to_latex

with job(snakemake):
    cells = {
        task: read_table(path, COLUMNS)
        for task, path in zip(snakemake.params.tasks, snakemake.input.cells, strict=True)
    }
    table = behaviour_cloning_table(cells, Grid.from_section(snakemake.params.grid))
    printed = printable(table)
    csv, markdown, latex = snakemake.output
    write_text(table.to_csv(index=False), csv)
    write_text(printed.to_markdown(index=False, disable_numparse=True) + "\n", markdown)
    write_text(to_latex(printed), latex)
