"""Take the best trial's policy out of a cell's study, and all trials as a table."""

from pathlib import Path

from t2l.artefacts import read_text, write_table
from t2l.errors import ArtefactError
from t2l.gains import Cell
from t2l.jobs import job
from t2l.policies import checkpoint
from t2l.rl.chosen import write_chosen
from t2l.rl.outcome import UnfinishedError, best
from t2l.rl.trials import open_study, table

workers = snakemake.input.workers

with job(snakemake, markers=workers):
    params, folder = snakemake.params, Path(snakemake.params.folder)
    cell = Cell.from_name(snakemake.wildcards.cell)
    name = read_text(workers[0], "the name of a study").strip()
    study = open_study(params.storage, folder / "trials.journal", name)
    try:
        found = best(study, folder / "store", params.trials)
    except UnfinishedError as error:
        found = f"says that tuning is done, but {error}"
        raise ArtefactError(workers[0], found, "a study that is done") from None
    write_table(table(study).assign(kp=cell.kp, kd=cell.kd), snakemake.output.trials)
    write_table(found.history.assign(kp=cell.kp, kd=cell.kd), snakemake.output.training)
    checkpoint.save(found.policy, snakemake.output.policy)
    write_chosen(snakemake.output.chosen, cell, found.number, found.choice, found.evaluation)
