"""Regions of gains compared with collections as the unit, as a table and a figure."""

import pandas as pd

from t2l.artefacts import read_table
from t2l.figures.collections import collections
from t2l.gains import Grid
from t2l.jobs import job
from t2l.plotting.style import write
from t2l.stats.collections import (
    COLUMNS,
    by_collection,
    collections_table,
    printable_collections,
)
from t2l.stats.text import write_printed

with job(snakemake):
    params, output = snakemake.params, snakemake.output
    tables = {}
    for path, (name, number) in zip(snakemake.input, params.of, strict=True):
        own = read_table(path, COLUMNS[1:]).assign(collection=number)
        tables.setdefault(name, []).append(own)
    cells, grid = (
        {name: pd.concat(own) for name, own in tables.items()},
        Grid.from_section(params.grid),
    )
    table = collections_table(cells, grid)
    write_printed(table, printable_collections(table), output.table)
    of_collections = {name: by_collection(own, grid) for name, own in cells.items()}
    write(collections(table, of_collections), output.figure)
