"""Judge every statement of the study that can be tested, and write table and page."""

from t2l.artefacts import write_text
from t2l.jobs import job
from t2l.report.scoreboard import render
from t2l.study.evidence import Evidence
from t2l.study.scoreboard.table import printable_scoreboard, scoreboard, to_latex

with job(snakemake):
    evidence = Evidence.read(snakemake.input)
    table = scoreboard(evidence)
    printed = printable_scoreboard(table)
    output = snakemake.output
    write_text(table.to_csv(index=False), output.csv)
    write_text(printed.to_markdown(index=False, disable_numparse=True) + "\n", output.markdown)
    write_text(to_latex(printed), output.latex)
    write_text(render(table, evidence.studies, snakemake.params.robot), output.page)
