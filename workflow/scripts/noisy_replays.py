"""Replay demonstrations in one cell with noise on every command."""

import pandas as pd

from t2l.actions import make_control
from t2l.artefacts import read_table, write_table
from t2l.demos.dataset import read_demonstrations
from t2l.gains import Cell
from t2l.jobs import job
from t2l.seeds import generator
from t2l.study.attenuation.noise import magnitudes, noise_table, noisy_replays, traces
from t2l.study.attenuation.success import COLUMNS, by_cell
from t2l.tasks import make_task

with job(snakemake):
    params = snakemake.params
    task = make_task(params.task)
    cell = Cell.from_name(snakemake.wildcards.cell)
    demonstrations = read_demonstrations(snakemake.input.demonstrations, task)
    control = make_control(params.actions, cell, task.robot, task.model)
    sizes = magnitudes(by_cell(read_table(snakemake.input.cells, COLUMNS)), cell)
    how = (control, params.decimation, params.hold)

    def _rng(*names):
        # no cell in it: the noise, in units of its magnitude, is the same in every cell
        return generator(params.seed, "noisy_replays", snakemake.wildcards.task, *names)

    tables = [
        noise_table(
            noisy_replays(
                task, demonstrations, *how, size, params.repetitions, _rng(name), snakemake.threads
            ),
            *(cell, name, size),
        )
        for name, size in sizes.items()
    ]
    write_table(pd.concat(tables, ignore_index=True), snakemake.output.replays)
    shown = traces(task, demonstrations[0], *how, sizes["same"], _rng("traces"))
    write_table(shown, snakemake.output.traces)
