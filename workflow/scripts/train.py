"""Train one cell's policy."""

from t2l.artefacts import write_table
from t2l.demos.dataset import read_replays
from t2l.gains import Cell
from t2l.jobs import job
from t2l.policies import POLICIES, Episode, checkpoint
from t2l.seeds import torch_seed
from t2l.tasks import make_task

with job(snakemake):
    task = make_task(snakemake.params.task)
    cell = Cell.from_name(snakemake.wildcards.cell)
    replays = read_replays(snakemake.input.demonstrations, task)
    settings = dict(snakemake.params.settings)
    kind = POLICIES.find(settings.pop("policy"))
    policy, losses = kind.fit(
        [Episode(*replay) for replay in replays],
        kind.settings(**settings),
        seed=torch_seed(snakemake.params.seed, "train", snakemake.wildcards.task, cell.name),
        threads=snakemake.threads,
    )
    write_table(losses.assign(kp=cell.kp, kd=cell.kd), snakemake.output.losses)
    checkpoint.save(policy, snakemake.output.policy)
