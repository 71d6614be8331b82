"""Draw commanded and achieved positions of the first replay in every corner cell."""

from t2l.actions import make_control
from t2l.demos.episodes import read_episodes
from t2l.demos.tracked import tracked
from t2l.figures.tracking import tracking
from t2l.gains import Cell
from t2l.jobs import job
from t2l.plotting.style import short, title, write
from t2l.tasks import make_task

with job(snakemake):
    task = make_task(snakemake.params.task)
    heading = title(snakemake.wildcards.task)
    episodes = {}
    for name, path in zip(snakemake.params.cells, snakemake.input, strict=True):
        control = make_control(
            snakemake.params.actions, Cell.from_name(name), task.robot, task.model
        )
        episodes[control.cell] = tracked(task, control, *read_episodes(path, task)[0])
    controller = control.controller
    labels = short(controller.command_names).values()
    units = controller.command_units
    write(
        tracking(
            episodes,
            # every second of up to seven, three of more
            shown={
                f"{label} [{unit}]": i
                for i, (label, unit) in enumerate(zip(labels, units, strict=True))
                if i % max(2, len(units) // 3) == 1
            },
            rate_hz=snakemake.params.rate_hz,
            title=f"{heading}: a retargeted demonstration at the corners of the grid",
        ),
        snakemake.output,
    )
