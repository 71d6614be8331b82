"""Fit one set of actuators to the recordings of all cells, whose gains are known."""

import logging

from t2l.artefacts import write_table
from t2l.identify.artefacts import loss_table
from t2l.identify.known_gains import identify_actuators
from t2l.identify.known_gains_artefacts import write_actuators
from t2l.jobs import job
from t2l.recordings.log import read_recording

with job(snakemake):
    log = logging.getLogger("t2l.identify")
    recordings = [read_recording(path) for path in snakemake.input.tables]

    def progress(iteration: int, loss: float) -> None:
        """Log every round."""
        log.info("round %d: mean squared error %.3g rad²", iteration, loss)

    rounds, threads = snakemake.params.rounds, snakemake.threads
    found = identify_actuators(recordings, rounds, threads, progress)
    write_table(loss_table(found.losses, recordings), snakemake.output.losses)
    write_actuators(found, recordings[0].joints, snakemake.output.actuators)
