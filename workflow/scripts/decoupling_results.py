"""Compare pairings of gains and behaviours, and draw their stiffness over training."""

from t2l.artefacts import read_table, write_table
from t2l.jobs import job
from t2l.plotting.style import write
from t2l.stats.text import write_printed
from t2l.study.decoupling.figures import stiffness_over_training
from t2l.study.decoupling.pairing import Pairing
from t2l.study.decoupling.statistics import HEADERS, decoupling_table, printable_decoupling
from t2l.study.decoupling.summary import summarise
from t2l.study.decoupling.training import COLUMNS

with job(snakemake):
    params, output = snakemake.params, snakemake.output
    pairings = [Pairing(**entry) for entry in params.pairings]
    each = [(pairing, seed) for pairing in pairings for seed in params.seeds]
    tables = {
        key: read_table(path, COLUMNS) for key, path in zip(each, snakemake.input, strict=True)
    }
    trainings = summarise(tables)
    write_table(trainings, output.trainings)
    table = decoupling_table(trainings, [pairing.name for pairing in pairings])
    write_printed(table, printable_decoupling(table), output.table, HEADERS)
    by_name = {
        pairing.name: {seed: tables[pairing, seed] for seed in params.seeds} for pairing in pairings
    }
    write(stiffness_over_training(by_name), output.figure)
