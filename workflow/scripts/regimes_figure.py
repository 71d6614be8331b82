"""Draw which gains each way of learning prefers."""

import pandas as pd

from t2l.artefacts import read_table
from t2l.gains import Grid
from t2l.jobs import job
from t2l.plotting.style import write
from t2l.study.regimes import CLONING_COLUMNS, TRANSFER_COLUMNS, regimes

with job(snakemake):
    given, params = snakemake.input, snakemake.params
    cloning = [read_table(path, CLONING_COLUMNS) for path in given.cloning]
    # of the first condition
    (transfer,) = (read_table(path, TRANSFER_COLUMNS) for path in given.transfer)
    figure = regimes(
        pd.concat(cloning)[list(CLONING_COLUMNS)],
        Grid.from_section(params.grid),
        transfer[list(TRANSFER_COLUMNS)],
        Grid.from_section(params.recording_grid),
    )
    write(figure, snakemake.output)
