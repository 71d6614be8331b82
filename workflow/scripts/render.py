"""Render what cameras see of the demonstrations, at the policy's rate."""

from pathlib import Path

from t2l.demos.dataset import read_demonstrations
from t2l.demos.pictures import render, write_pictures
from t2l.jobs import job
from t2l.tasks import make_task
from t2l.tasks.cameras import Cameras

with job(snakemake):
    params = snakemake.params
    task = make_task(params.task)
    demonstrations = read_demonstrations(snakemake.input.demonstrations, task)
    with Cameras(task.spec(visual=True).compile(), **params.observation) as cameras:
        pictures = render(demonstrations, cameras, params.decimation, params.settings["hold"])
        path = Path(snakemake.output.pictures)
        write_pictures(pictures, cameras, task, params.settings["policy_rate_hz"], path)
