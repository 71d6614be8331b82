"""Have an operator demonstrate through the controller of one cell, and keep what succeeds."""

from t2l.actions import make_control
from t2l.artefacts import write_table
from t2l.demos.collect import attempt_table, collect
from t2l.demos.episodes import write_episodes
from t2l.demos.operator import Person
from t2l.gains import Cell
from t2l.jobs import job
from t2l.seeds import generator
from t2l.tasks import make_task

with job(snakemake):
    params, wildcards = snakemake.params, snakemake.wildcards
    task, cell = make_task(params.task), Cell.from_name(wildcards.cell)
    attempts = collect(
        task,
        make_control(params.actions, cell, task.robot, task.model),
        params.decimation,
        **params.wanted,
        person=Person(**params.operator),
        # the expert's: every cell begins with the same starts
        rng=generator(params.seed, "demonstrations", wildcards.task),
        threads=snakemake.threads,
    )
    write_episodes([a.episode for a in attempts if a.success], snakemake.output.episodes)
    write_table(attempt_table(attempts, cell), snakemake.output.replays)
