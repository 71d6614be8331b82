"""Write what the policies of a cell are trained on as a LeRobot data set."""

from pathlib import Path

from t2l.actions import make_control
from t2l.demos.dataset import write_dataset
from t2l.demos.episodes import read_episodes, read_numbers
from t2l.demos.pictures import read_pictures
from t2l.gains import Cell
from t2l.jobs import job
from t2l.tasks import make_task

with job(snakemake):
    params = snakemake.params
    task = make_task(params.task)
    cell = Cell.from_name(snakemake.wildcards.cell)
    control = make_control(params.actions, cell, task.robot, task.model)
    (episodes,), pictures = snakemake.input.episodes, ()
    if snakemake.input.get("pictures"):
        store, frames = read_pictures(snakemake.input.pictures, **params.observation)
        pictures = (store[frames[number]] for number in read_numbers(episodes))
    write_dataset(
        read_episodes(episodes, task),
        task,
        control.actions.names,
        params.settings["policy_rate_hz"],
        Path(snakemake.output[0]),
        **params.observation,
        pictures=pictures,
    )
