"""Draw steps and sines at the corners of the grid."""

from t2l.artefacts import read_table
from t2l.figures.responses import responses
from t2l.gains import Cell, Grid
from t2l.hardware.steps import COLUMNS
from t2l.identify.artefacts import TRACE_COLUMNS
from t2l.jobs import job
from t2l.plotting.style import write

with job(snakemake):
    params = snakemake.params
    cells = [Cell.from_name(name) for name in params.cells]
    steps = read_table(snakemake.input.steps, COLUMNS)
    stepped = {c: steps[(steps.kp == c.kp) & (steps.kd == c.kd)] for c in cells}
    sines = {}
    for cell, path in zip(cells, snakemake.input.traces, strict=True):
        trace = read_table(path, TRACE_COLUMNS)
        trace = trace[trace.joint.isin(steps.joint)].dropna(subset="q")
        # a sine begins at home
        home = trace.groupby("joint").q_des.transform("first")
        sines[cell] = trace.assign(q=trace.q - home, q_des=trace.q_des - home)
    figure = responses({"step": stepped, "sine": sines}, Grid.from_section(params.grid))
    write(figure, snakemake.output)
