"""Draw commanded and achieved positions of the first replay in every corner cell."""

from t2l.demos.dataset import read_replays
from t2l.figures.style import title, write
from t2l.figures.tracking import tracking
from t2l.gains import Cell
from t2l.jobs import job
from t2l.tasks import make_task

with job(snakemake):
    task = make_task(snakemake.params.task)
    dof = len(task.robot.joints)
    heading = title(snakemake.wildcards.task)
    episodes = {}
    for name, path in zip(snakemake.params.cells, snakemake.input, strict=True):
        observation, action = read_replays(path, task)[0]
        # an observation begins with q, an action with q_des
        episodes[Cell.from_name(name)] = (action[:, :dof], observation[:, :dof])
    write(
        tracking(
            episodes,
            joints={f"joint {i + 1}": i for i in range(1, dof, 2)},
            rate_hz=snakemake.params.rate_hz,
            title=f"{heading}: a retargeted demonstration at the corners of the grid",
        ),
        snakemake.output,
    )
