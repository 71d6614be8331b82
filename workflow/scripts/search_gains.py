"""Run trials of a search of gains until it has enough."""

import logging
from pathlib import Path

from t2l.artefacts import write_text
from t2l.jobs import job
from t2l.rl.gain_search import asked_for, work

with job(snakemake):
    params, log = snakemake.params, logging.getLogger("t2l.tune")
    folder = Path(snakemake.output[0]).parent
    asked = asked_for(params.entry, params.task, params.settings, params.storage, folder)
    log.info("study %s", asked[0].study_name)
    # one of several workers does not know how many there are
    work(*asked, params.entry["seed"], 1, snakemake.threads, log.info)
    write_text(f"{asked[0].study_name}\n", snakemake.output[0])
