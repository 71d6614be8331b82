"""Train policies of cells and training seeds, side by side if there are several."""

from t2l.actions import make_control
from t2l.artefacts import write_table
from t2l.bc.training import train, views_of
from t2l.gains import Cell
from t2l.jobs import job
from t2l.policies import checkpoint
from t2l.tasks import make_task

with job(snakemake):
    params, wildcards = snakemake.params, snakemake.wildcards
    task = make_task(params.task)
    cells = [Cell.from_name(name) for name in params.cells]
    control = make_control(params.actions, cells[0], task.robot, task.model)
    pictures = snakemake.input.get("pictures")
    trained = train(
        task,
        dict(zip(cells, snakemake.input.episodes, strict=True)),
        params.seeds,
        (params.seed, "train", wildcards.task),
        control.actions.names,
        params.demonstrations.get("used"),
        params.settings,
        snakemake.threads,
        views_of(pictures, **params.observation) if pictures else (),
    )
    outputs = zip(snakemake.output.policies, snakemake.output.losses, strict=True)
    for (policy, losses), (policy_path, losses_path) in zip(trained, outputs, strict=True):
        write_table(losses, losses_path)
        checkpoint.save(policy, policy_path)
