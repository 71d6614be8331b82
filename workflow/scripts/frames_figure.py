"""Render a demonstration, a success and a failure of each kind."""

from t2l.artefacts import read_table
from t2l.bc.rollout import TRACE_COLUMNS, pick_traces
from t2l.demos.dataset import read_demonstrations
from t2l.figures.frames import filmstrips
from t2l.jobs import job
from t2l.plotting.style import title, write
from t2l.sim.batch import TIMESTEP_S
from t2l.tasks import make_task

with job(snakemake):
    task = make_task(snakemake.params.task)
    demonstration = read_demonstrations(snakemake.input.demonstrations, task)[0]
    traces = [read_table(path, TRACE_COLUMNS) for path in snakemake.input.traces]
    policies = list(zip(snakemake.params.cells, traces, strict=True))
    strips = {
        "demonstration": ([k * TIMESTEP_S for k in range(len(demonstration))], demonstration.qpos)
    }
    strips |= pick_traces(policies, snakemake.params.preferred)
    write(
        filmstrips(
            task, strips, columns=6, title=f"{title(snakemake.wildcards.task)}: {task.instruction}"
        ),
        snakemake.output,
    )
