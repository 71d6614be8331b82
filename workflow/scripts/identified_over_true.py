"""Set what identification found beside what is true of a simulated robot."""

from t2l.figures.identification import over_true as draw
from t2l.gains import Cell
from t2l.hardware import truth_of
from t2l.identify.artefacts import read_parameters
from t2l.jobs import job
from t2l.plotting.style import write
from t2l.robots import make_robot
from t2l.stats.identification import over_true, printable
from t2l.stats.text import write_printed

with job(snakemake):
    cells = map(Cell.from_name, snakemake.params.cells)
    found = dict(zip(cells, map(read_parameters, snakemake.input), strict=True))
    robot = make_robot(snakemake.params.robot["name"])
    table = over_true(found, truth_of(snakemake.params.robot, robot), robot.joints)
    write_printed(table, printable(table), snakemake.output.table)
    write(draw(table), snakemake.output.figure)
