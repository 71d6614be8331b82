"""Render a success and a failure of a policy that was learned in simulation alone."""

from t2l.artefacts import read_table
from t2l.figures.frames import learned_frames
from t2l.jobs import job
from t2l.plotting.style import write
from t2l.rl.alone import SHOWN_COLUMNS
from t2l.tasks import make_task

with job(snakemake):
    task, episodes = (
        make_task(snakemake.params.task),
        read_table(snakemake.input[0], SHOWN_COLUMNS),
    )
    write(learned_frames(task, episodes, snakemake.wildcards.learned), snakemake.output)
