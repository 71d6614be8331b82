"""Draw the figures and write the page that tells the story."""

from pathlib import Path

from t2l.figures.diagnosis import draw_explanation
from t2l.jobs import job
from t2l.report import write_report

with job(snakemake):
    folder = Path(snakemake.output.page).parent
    draw_explanation(folder)
    write_report(folder)
