"""Draw how often replays succeed under noise, and what they look like at two corners."""

import pandas as pd

from t2l.artefacts import read_table
from t2l.gains import Cell, Grid
from t2l.jobs import job
from t2l.plotting.style import short, title, write
from t2l.study.attenuation.figures import noise_success, noise_traces
from t2l.study.attenuation.noise import COLUMNS, TRACE_COLUMNS

with job(snakemake):
    grid = Grid.from_section(snakemake.params.grid)
    heading = title(snakemake.wildcards.task)
    replays = pd.concat([read_table(path, COLUMNS) for path in snakemake.input.replays])
    undisturbed = read_table(snakemake.input.cells, ("kp", "kd", "replay_success"))
    write(noise_success(replays, undisturbed, grid, heading), snakemake.output.success)
    traces = {
        Cell.from_name(name): read_table(path, TRACE_COLUMNS)
        for name, path in zip(snakemake.params.opposites, snakemake.input.traces, strict=True)
    }
    joints = [name for name in next(iter(traces.values())).columns if name.startswith("q.")]
    # every second of up to seven, three of more
    shown = {
        label: name
        for i, (name, label) in enumerate(short(joints).items())
        if i % max(2, len(joints) // 3) == 1
    }
    write(noise_traces(traces, shown, grid, heading), snakemake.output.traces)
