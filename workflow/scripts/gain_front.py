"""Train the trials of a front again, and write what a search of gains came to."""

import logging
from pathlib import Path

from t2l.figures.pareto import write_search
from t2l.jobs import job
from t2l.rl.gain_search import asked_for, confirm
from t2l.rl.gain_table import gain_table

with job(snakemake):
    params, log = snakemake.params, logging.getLogger("t2l.tune")
    folder = Path(snakemake.output.trials).parent
    asked = asked_for(params.entry, params.task, params.settings, params.storage, folder)
    study, problem, _, _ = asked
    confirm(*asked, snakemake.threads, log.info)
    write_search(gain_table(study, problem.objectives), folder)
