"""Take what a cell is to be trained with: given, or the best trial's; all trials as a table."""

from pathlib import Path

from t2l.artefacts import read_text, write_table
from t2l.errors import ArtefactError
from t2l.gains import Cell
from t2l.jobs import job
from t2l.rl.problem import Condition
from t2l.rl.results import write_chosen
from t2l.rl.trials import UnfinishedError, best, no_trials, open_study, table

workers = snakemake.input.workers

with job(snakemake, markers=workers):
    params, output = snakemake.params, snakemake.output
    cell = Cell.from_name(snakemake.wildcards.cell)
    condition = Condition.from_entry(params.condition)
    robot = condition.make_task().robot
    if condition.searched:
        name = read_text(workers[0], "the name of a study").strip()
        study = open_study(params.storage, Path(params.folder) / "trials.journal", name)
        try:
            found = best(study, robot, params.trials)
        except UnfinishedError as error:
            complaint = f"says that tuning is done, but {error}"
            raise ArtefactError(workers[0], complaint, "a study that is done") from None
        choice, how, trials = found.choice, f"trial {found.number}", table(study)
    else:
        choice, how, trials = condition.given(cell), "given", no_trials(robot)
    write_table(trials.assign(kp=cell.kp, kd=cell.kd), output.trials)
    write_chosen(output.chosen, cell, choice, how)
