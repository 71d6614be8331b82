"""Take the best trial's policy out of a cell's study, and all trials as a table."""

from pathlib import Path

from t2l.artefacts import write_table
from t2l.gains import Cell
from t2l.jobs import job
from t2l.rl.chosen import write_chosen
from t2l.rl.outcome import best
from t2l.rl.trials import open_study, table

with job(snakemake.log[0]):
    params, folder = snakemake.params, Path(snakemake.params.folder)
    cell = Cell.from_name(snakemake.wildcards.cell)
    name = Path(snakemake.input.workers[0]).read_text().strip()
    study = open_study(params.storage, folder / "trials.journal", name)
    found = best(study, folder / "store", params.trials)
    write_table(table(study).assign(kp=cell.kp, kd=cell.kd), snakemake.output.trials)
    write_table(found.history.assign(kp=cell.kp, kd=cell.kd), snakemake.output.training)
    found.policy.save(snakemake.output.policy)
    write_chosen(snakemake.output.chosen, cell, found.number, found.choice, found.evaluation)
