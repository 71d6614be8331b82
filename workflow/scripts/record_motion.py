"""Record one cell's identification motion."""

from t2l.gains import Cell
from t2l.hardware.backends import obtain_recording
from t2l.hardware.motion import Motion
from t2l.jobs import job
from t2l.recordings.log import write_recording
from t2l.robots import make_robot

with job(snakemake):
    cell = Cell.from_name(snakemake.wildcards.cell)
    motion = Motion(**snakemake.params.motion)
    recording = obtain_recording(
        snakemake.params.robot, make_robot(snakemake.params.robot["name"]), cell, motion
    )
    write_recording(recording, snakemake.output.table, format="parquet")
