"""Decide by the configuration's rule whether the study's claim about transfer is reproduced."""

from t2l.artefacts import read_table
from t2l.jobs import job
from t2l.stats.text import write_printed
from t2l.stats.transfer import COLUMNS
from t2l.study.transfer.decision import POLICY_COLUMNS, decide, printable_decision
from t2l.study.transfer.rule import Rule

with job(snakemake):
    rollouts = read_table(snakemake.input.rollouts, COLUMNS)
    policies = read_table(snakemake.input.policies, POLICY_COLUMNS)
    table = decide(rollouts, policies, Rule(**snakemake.params.rule))
    write_printed(table, printable_decision(table), snakemake.output)
