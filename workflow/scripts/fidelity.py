"""Replay demonstrations in one cell at many rates, with either way of holding a command."""

import pandas as pd

from t2l.actions import make_control
from t2l.artefacts import write_table
from t2l.demos.dataset import read_demonstrations
from t2l.demos.replay import replay, replay_table
from t2l.demos.retarget import HOLDS
from t2l.gains import Cell
from t2l.jobs import job
from t2l.tasks import make_task

with job(snakemake):
    task = make_task(snakemake.params.task)
    cell = Cell.from_name(snakemake.wildcards.cell)
    demonstrations = read_demonstrations(snakemake.input.demonstrations, task)
    demonstrations = demonstrations[: snakemake.params.replays]
    control = make_control(snakemake.params.actions, cell, task.robot, task.model)
    tables = [
        replay_table(
            replay(task, demonstrations, control, decimation, hold, snakemake.threads), cell
        ).assign(hold=hold, decimation=decimation)
        for hold in HOLDS
        for decimation in snakemake.params.decimations
    ]
    write_table(pd.concat(tables, ignore_index=True), snakemake.output[0])
