"""Step the robot's command at the corners of the grid."""

import pandas as pd

from t2l.artefacts import write_table
from t2l.gains import Cell
from t2l.hardware import open_backend
from t2l.hardware.steps import step_responses
from t2l.jobs import job
from t2l.robots import make_robot

with job(snakemake):
    params = snakemake.params
    with open_backend(params.robot, make_robot(params.robot["name"])) as arm:
        tables = [step_responses(arm, Cell.from_name(name)) for name in params.cells]
    write_table(pd.concat(tables, ignore_index=True), snakemake.output[0])
