"""Record one cell's identification motion."""

from t2l.gains import Cell
from t2l.hardware import open_backend
from t2l.hardware.identification_motion import identification_motion
from t2l.jobs import job
from t2l.recordings.log import write_recording
from t2l.robots import make_robot

with job(snakemake):
    params, cell = snakemake.params, Cell.from_name(snakemake.wildcards.cell)
    robot = make_robot(params.robot["name"])
    with open_backend(params.robot, robot) as arm:
        recording = arm.record(identification_motion(robot, cell, **params.motion))
    write_recording(recording, snakemake.output.table, format="parquet")
