"""Decide by the configuration's rule whether the study's claim about transfer is reproduced."""

from t2l.artefacts import read_table, write_text
from t2l.jobs import job
from t2l.stats import decision, transfer
from t2l.stats.text import latex

with job(snakemake):
    csv, markdown, tex = snakemake.output
    rollouts = read_table(snakemake.input.rollouts, transfer.COLUMNS)
    policies = read_table(snakemake.input.policies, decision.POLICY_COLUMNS)
    table = decision.decide(rollouts, policies, decision.Rule(**snakemake.params.rule))
    printed = decision.printable_decision(table)
    write_text(table.to_csv(index=False), csv)
    write_text(printed.to_markdown(index=False, disable_numparse=True) + "\n", markdown)
    write_text(latex(printed, {}), tex)
