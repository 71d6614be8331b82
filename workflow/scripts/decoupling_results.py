"""Compare pairings of gains and behaviours, and draw their stiffness over training."""

from t2l.artefacts import read_table, write_table, write_text
from t2l.decoupling.pairing import Pairing
from t2l.decoupling.summary import summarise
from t2l.decoupling.training import COLUMNS
from t2l.figures.decoupling import stiffness_over_training
from t2l.jobs import job
from t2l.plotting.style import write
from t2l.stats import decoupling
from t2l.stats.text import latex

with job(snakemake):
    params, output = snakemake.params, snakemake.output
    pairings = [Pairing(**entry) for entry in params.pairings]
    each = [(pairing, seed) for pairing in pairings for seed in params.seeds]
    tables = {
        key: read_table(path, COLUMNS) for key, path in zip(each, snakemake.input, strict=True)
    }
    trainings = summarise(tables)
    write_table(trainings, output.trainings)
    table = decoupling.decoupling_table(trainings, [pairing.name for pairing in pairings])
    csv, markdown, tex = output.table
    printed = decoupling.printable(table)
    write_text(table.to_csv(index=False), csv)
    write_text(printed.to_markdown(index=False, disable_numparse=True) + "\n", markdown)
    write_text(latex(printed, decoupling.HEADERS), tex)
    by_name = {
        pairing.name: {seed: tables[pairing, seed] for seed in params.seeds} for pairing in pairings
    }
    write(stiffness_over_training(by_name), output.figure)
