"""Draw how faithful retargeting is at each command rate."""

import pandas as pd

from t2l.artefacts import read_table
from t2l.configuration import SIMULATION_RATE_HZ
from t2l.demos.replay import TABLE_COLUMNS
from t2l.figures.fidelity import fidelity
from t2l.figures.style import title, write
from t2l.jobs import job

with job(snakemake.log[0]):
    columns = (*TABLE_COLUMNS, "hold", "decimation")
    table = pd.concat([read_table(path, columns) for path in snakemake.input])
    heading = f"{title(snakemake.wildcards.task)}: fidelity of torque-to-position retargeting"
    write(fidelity(table, SIMULATION_RATE_HZ, heading), snakemake.output)
