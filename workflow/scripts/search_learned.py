"""Look for the action scales of a cell of a task that is learned in simulation alone."""

import logging
from pathlib import Path

from t2l.artefacts import write_table
from t2l.gains import Cell
from t2l.jobs import job
from t2l.rl.alone import problem_of, search_of, search_scales, settings_of
from t2l.rl.results import write_chosen
from t2l.rl.trials import open_study, table

with job(snakemake):
    params, output = snakemake.params, snakemake.output
    cell = Cell.from_name(snakemake.wildcards.cell)
    problem, _ = problem_of(params.entry, params.task, cell)
    settings, search = (
        settings_of(params.settings, params.entry),
        search_of(params.tuning, problem.task),
    )
    name, log = problem.study_name(search, settings, params.seed), logging.getLogger("t2l.tune")
    study = open_study(
        params.tuning["storage"], Path(output.chosen).parent / "trials.journal", name
    )
    log.info("study %s", name)
    workers, threads = params.tuning["workers"], snakemake.threads
    found = search_scales(study, problem, search, settings, params.seed, workers, threads, log.info)
    trials = table(study).assign(task=problem.condition.name, kp=cell.kp, kd=cell.kd)
    write_table(trials, output.trials)
    write_chosen(output.chosen, cell, found.choice, f"trial {found.number}")
