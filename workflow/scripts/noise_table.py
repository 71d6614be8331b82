"""Tabulate success of replays under noise by region, and its rank correlation with Kp / Kd."""

import pandas as pd

from t2l.artefacts import read_table
from t2l.gains import Grid
from t2l.jobs import job
from t2l.stats.text import write_printed
from t2l.study.attenuation.noise import COLUMNS
from t2l.study.attenuation.statistics import noise_table, printable_noise

with job(snakemake):
    tasks, paths = snakemake.params.tasks, snakemake.input.replays
    # the paths of one task after those of another
    each = len(paths) // len(tasks)
    replays = {
        task: pd.concat([read_table(path, COLUMNS) for path in paths[i * each : (i + 1) * each]])
        for i, task in enumerate(tasks)
    }
    undisturbed = {
        task: read_table(path, ("kp", "kd", "replay_success"))
        for task, path in zip(tasks, snakemake.input.cells, strict=True)
    }
    table = noise_table(replays, undisturbed, Grid.from_section(snakemake.params.grid))
    write_printed(table, printable_noise(table), snakemake.output)
