"""Run trials of one cell until its study has enough."""

import logging
from pathlib import Path

from t2l.artefacts import write_text
from t2l.gains import Cell
from t2l.identify.artefacts import read_parameters
from t2l.jobs import job
from t2l.rl.condition import Condition
from t2l.rl.problem import Problem
from t2l.rl.settings import Search, Settings
from t2l.rl.trials import open_study
from t2l.rl.tune import work

with job(snakemake):
    params, folder = snakemake.params, Path(snakemake.params.folder)
    problem = Problem(
        Condition.from_entry(params.condition),
        Cell.from_name(snakemake.wildcards.cell),
        read_parameters(snakemake.input.parameters),
        rate_hz=params.rate_hz,
        horizon_s=params.horizon_s,
    )
    settings = Settings(**params.settings)
    search = Search.from_section(params.tuning, problem.task)
    name = problem.study_name(search, settings, params.seed)
    study = open_study(params.tuning["storage"], folder / "trials.journal", name)
    log = logging.getLogger("t2l.tune")
    log.info("study %s", name)
    work(study, problem, search, settings, params.seed, snakemake.threads, log.info)
    write_text(f"{name}\n", snakemake.output[0])
