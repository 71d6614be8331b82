"""Make scoreboard, tables and figures of the documentation of kept results."""

from pathlib import Path

from t2l.jobs import job
from t2l.report.kept import registered, write_all

with job(snakemake):
    data = Path(snakemake.input.data[0]).parent
    root = Path(snakemake.output.tables).parent
    write_all(data, registered(Path(snakemake.input.study)), Path(), root)
