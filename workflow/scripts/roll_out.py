"""Roll out one cell's policy from starts that no demonstration had."""

from contextlib import nullcontext

from t2l.actions import make_control
from t2l.artefacts import write_table
from t2l.bc.rollout import roll_out, traces
from t2l.gains import Cell
from t2l.jobs import job
from t2l.policies import checkpoint
from t2l.seeds import generator
from t2l.tasks import make_task
from t2l.tasks.cameras import Cameras

with job(snakemake):
    task = make_task(snakemake.params.task)
    policy = checkpoint.load(snakemake.input.policy)
    settings, cell = snakemake.params.settings, Cell.from_name(snakemake.wildcards.cell)
    # the same starts in every cell, so that cells differ by their gains alone
    rng = generator(snakemake.params.seed, "rollouts", snakemake.wildcards.task)
    seen, cameras = snakemake.params.observation, nullcontext()
    if seen["cameras"]:
        cameras = Cameras(task.spec(visual=True).compile(), **seen)
    with cameras as opened:
        rollouts = roll_out(
            task,
            policy.act,
            history=policy.history,
            executed=settings["executed_actions"],
            control=make_control(snakemake.params.actions, cell, task.robot, task.model),
            starts=task.sample_starts(rng, settings["count"]),
            decimation=snakemake.params.decimation,
            threads=snakemake.threads,
            cameras=opened,
        )
    write_table(traces(rollouts, snakemake.params.decimation), snakemake.output.traces)
    write_table(rollouts.table, snakemake.output.rollouts)
