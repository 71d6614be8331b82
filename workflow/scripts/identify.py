"""Identify one cell's training simulator."""

import logging

from t2l.gains import Cell
from t2l.identify.actuators import Settings, identify
from t2l.identify.artefacts import write_losses, write_parameters, write_trace
from t2l.jobs import job
from t2l.recordings.log import read_recording
from t2l.seeds import seed_sequence

with job(snakemake):
    log = logging.getLogger("t2l.identify")
    cell = Cell.from_name(snakemake.wildcards.cell)
    recording = read_recording(snakemake.input.table)
    seed = seed_sequence(snakemake.params.seed, "identify", cell.name).generate_state(1)[0]
    settings = Settings(**snakemake.params.settings)

    def progress(iteration: int, loss: float) -> None:
        """Log every twentieth generation."""
        if iteration % 20 == 0:
            log.info("iteration %d of %d: loss %.3g", iteration, settings.iterations, loss)

    found = identify(recording, settings, int(seed), snakemake.threads, progress)
    for name, joint in found.bounds:
        log.info("%s of %s ended on a bound", name, recording.joints[joint])
    write_losses(found, cell, snakemake.output.losses)
    write_trace(recording, found, cell, snakemake.output.trace)
    write_parameters(found, cell, recording.joints, snakemake.output.parameters)
