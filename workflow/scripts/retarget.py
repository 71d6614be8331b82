"""Retarget the demonstrations to one cell and keep those that still succeed."""

from t2l.actions import make_control
from t2l.artefacts import write_table
from t2l.demos.dataset import read_demonstrations
from t2l.demos.episodes import write_episodes
from t2l.demos.replay import replay, replay_table, successful
from t2l.gains import Cell
from t2l.jobs import job
from t2l.tasks import make_task

with job(snakemake):
    task = make_task(snakemake.params.task)
    cell = Cell.from_name(snakemake.wildcards.cell)
    demonstrations = read_demonstrations(snakemake.input.demonstrations, task)
    control = make_control(snakemake.params.actions, cell, task.robot, task.model)
    settings, decimation = snakemake.params.settings, snakemake.params.decimation
    replays = replay(task, demonstrations, control, decimation, settings["hold"], snakemake.threads)
    kept = successful(replays, cell)
    numbers = [number for number, r in enumerate(replays) if r.success]
    write_episodes([r.episode for r in kept], snakemake.output.episodes, numbers)
    write_table(replay_table(replays, cell), snakemake.output.replays)
