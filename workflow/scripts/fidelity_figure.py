"""Draw how faithful retargeting is at each command rate."""

import pandas as pd

from t2l.artefacts import read_table
from t2l.figures.fidelity import COLUMNS, fidelity
from t2l.jobs import job
from t2l.plotting.style import title, write

with job(snakemake):
    table = pd.concat([read_table(path, COLUMNS) for path in snakemake.input])
    heading = f"{title(snakemake.wildcards.task)}: fidelity of torque-to-position retargeting"
    write(fidelity(table, snakemake.params.simulation_rate_hz, heading), snakemake.output)
