"""Gather what was identified, one row a cell."""

from t2l.artefacts import write_table
from t2l.identify.artefacts import summarise
from t2l.jobs import job

with job(snakemake):
    write_table(summarise(snakemake.input), snakemake.output[0])
