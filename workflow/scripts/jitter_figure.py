"""Draw how often rollouts jitter, and are stopped, by the period of the policy."""

from t2l.artefacts import read_table
from t2l.figures.transfer import JITTER_COLUMNS, jitter_by_period
from t2l.jobs import job
from t2l.plotting.style import write

with job(snakemake):
    write(jitter_by_period(read_table(snakemake.input[0], JITTER_COLUMNS)), snakemake.output)
