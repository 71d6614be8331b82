"""One cell's training simulator: identified alone, or of the actuators that all cells share."""

import logging

from t2l.artefacts import read_table, write_table
from t2l.gains import Cell
from t2l.identify.actuators import Settings, identify
from t2l.identify.artefacts import LOSS_COLUMNS, loss_table, write_parameters, write_trace
from t2l.identify.known_gains import in_simulator
from t2l.identify.known_gains_artefacts import read_actuators
from t2l.jobs import job
from t2l.recordings.log import read_recording
from t2l.seeds import seed_sequence

with job(snakemake):
    log = logging.getLogger("t2l.identify")
    cell = Cell.from_name(snakemake.wildcards.cell)
    recording = read_recording(snakemake.input.table)
    settings = Settings(**snakemake.params.settings)

    def progress(iteration: int, loss: float) -> None:
        """Log every twentieth generation."""
        if iteration % 20 == 0:
            log.info("iteration %d of %d: loss %.3g", iteration, settings.iterations, loss)

    if settings.gains == "known":
        shared = read_actuators(snakemake.input.actuators)
        losses = read_table(snakemake.input.losses, LOSS_COLUMNS)
        own = losses[(losses.kp == cell.kp) & (losses.kd == cell.kd)].loss.to_numpy()
        found = in_simulator(recording, *shared, own, settings.rate_hz)
    else:
        seed = seed_sequence(snakemake.params.seed, "identify", cell.name).generate_state(1)[0]
        found = identify(recording, settings, int(seed), snakemake.threads, progress)
    for name, joint in found.bounds:
        log.info("%s of %s ended on a bound", name, recording.joints[joint])
    write_table(loss_table(found.losses[:, None], [cell]), snakemake.output.losses)
    write_trace(recording, found, cell, snakemake.output.trace)
    write_parameters(found, cell, recording.joints, snakemake.output.parameters)
