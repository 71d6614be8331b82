"""Record successful demonstrations of a task."""

from pathlib import Path

from t2l.demos.dataset import write_demonstrations
from t2l.demos.expert import demonstrate
from t2l.jobs import job
from t2l.seeds import generator
from t2l.tasks import make_task

with job(snakemake):
    task = make_task(snakemake.params.task)
    demonstrations = demonstrate(
        task,
        **snakemake.params.settings,
        rng=generator(snakemake.params.seed, "demonstrations", snakemake.wildcards.task),
        threads=snakemake.threads,
    )
    write_demonstrations(demonstrations, task, Path(snakemake.output.demonstrations))
