"""Write the study's table of transfer, jitter by policy period, and where solutions exist."""

from t2l.artefacts import read_table
from t2l.gains import Grid
from t2l.jobs import job
from t2l.rl.problem import Condition
from t2l.stats import transfer
from t2l.stats.text import write_printed

with job(snakemake):
    grid = Grid.from_section(snakemake.params.grid)
    conditions = [Condition.from_entry(entry) for entry in snakemake.params.conditions]
    names = [condition.name for condition in conditions]
    rollouts = {
        name: read_table(path, transfer.COLUMNS)
        for name, path in zip(names, snakemake.input.rollouts, strict=True)
    }
    cells = {
        name: read_table(path, transfer.CELL_COLUMNS)
        for name, path in zip(names, snakemake.input.cells, strict=True)
    }
    first = conditions[0]
    rates = {
        condition.name: condition.policy_rate_hz
        for condition in conditions
        if (condition.task, condition.randomisation, condition.searched)
        == (first.task, first.randomisation, first.searched)
    }
    made = {
        "transfer": (transfer.transfer_table(rollouts, grid), transfer.printable_transfer),
        "jitter": (transfer.jitter_table(rollouts, rates), transfer.printable_jitter),
        "existence": (transfer.existence_table(cells, grid), transfer.printable_existence),
    }
    for key, (table, printable) in made.items():
        write_printed(table, printable(table), snakemake.output[key], transfer.HEADERS)
