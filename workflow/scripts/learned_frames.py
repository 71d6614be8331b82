"""Render a success and a failure of a policy that was learned in simulation alone."""

from t2l.artefacts import read_table
from t2l.figures.frames import filmstrips
from t2l.jobs import job
from t2l.plotting.style import title, write
from t2l.rl.alone import SHOWN_COLUMNS
from t2l.tasks import make_task

with job(snakemake):
    task, name = make_task(snakemake.params.task), snakemake.wildcards.learned
    table, strips = read_table(snakemake.input[0], SHOWN_COLUMNS), {}
    for success, rows in table.groupby("success", sort=False):
        label = "success" if success else "failure"
        strips[label] = rows.time_s.to_numpy(), list(rows.qpos)
    figure = filmstrips(task, strips, columns=6, title=f"{title(name)}: {task.instruction}")
    write(figure, snakemake.output)
