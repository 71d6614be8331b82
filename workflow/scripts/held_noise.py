"""Simulate joints under noise on their commands, in every cell of the grid."""

from t2l.artefacts import write_table
from t2l.gains import Cell
from t2l.jobs import job
from t2l.robots import make_robot
from t2l.seeds import generator
from t2l.study.attenuation.rack import held_noise, make_rack

with job(snakemake):
    settings = snakemake.params.settings
    table = held_noise(
        make_rack(make_robot(snakemake.params.robot), settings["inertias_kg_m2"]),
        [Cell.from_name(name) for name in snakemake.params.cells],
        settings["noise_rad"],
        snakemake.params.decimation,
        settings["replicates"],
        settings["time_constants"],
        generator(snakemake.params.seed, "held_noise"),
        snakemake.threads,
    )
    write_table(table, snakemake.output[0])
