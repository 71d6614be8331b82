"""Run trials of one cell, or of all cells of a condition, until their studies have enough."""

import logging
from pathlib import Path

from t2l.artefacts import write_text
from t2l.gains import Cell
from t2l.identify.artefacts import read_parameters
from t2l.jobs import job
from t2l.rl.problem import Condition, Problem
from t2l.rl.settings import Search, Settings
from t2l.rl.trials import open_study
from t2l.rl.tuning import work, work_side_by_side

with job(snakemake):
    params, folders = snakemake.params, [Path(path).parent for path in snakemake.output]
    condition, settings = Condition.from_entry(params.condition), Settings(**params.settings)
    log, studies = logging.getLogger("t2l.tune"), []
    for path, folder in zip(snakemake.input.parameters, folders, strict=True):
        problem = Problem(
            condition,
            Cell.from_name(folder.name),
            read_parameters(path),
            rate_hz=params.rate_hz,
            horizon_s=params.horizon_s,
        )
        search = Search.from_section(params.tuning, problem.task)
        name = problem.study_name(search, settings, params.seed)
        study = open_study(params.tuning["storage"], folder / "trials.journal", name)
        studies.append((study, problem))
        log.info("study %s", name)
    # one of several workers does not know how many there are
    workers, training = params.tuning.get("workers"), (search, settings, params.seed)
    if workers is None:
        work(*studies[0], *training, snakemake.threads, log.info)
    else:
        work_side_by_side(studies, *training, workers, snakemake.threads, log.info)
    for (study, _), path in zip(studies, snakemake.output, strict=True):
        write_text(f"{study.study_name}\n", path)
