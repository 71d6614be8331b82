"""Run a policy on the robot without one of its effects, from the starts of its deployment."""

from pathlib import Path

from t2l.artefacts import write_table
from t2l.gains import Cell
from t2l.identify.artefacts import read_parameters
from t2l.jobs import job
from t2l.policies import checkpoint
from t2l.rl.problem import Condition
from t2l.transfer.errors import rollout_table
from t2l.transfer.matched import Deployment, matched_rollouts

with job(snakemake):
    params, cell = snakemake.params, Cell.from_name(snakemake.wildcards.cell)
    policy = checkpoint.load(snakemake.input.policy)
    real, sim = matched_rollouts(
        {**params.robot, "without": [snakemake.wildcards.effect]},
        policy,
        Condition.from_entry(params.condition),
        cell,
        read_parameters(snakemake.input.parameters),
        Deployment.from_section(params.deployment, params.horizon_s, params.rate_hz),
        params.seed,
        Path(snakemake.output[0]).parent / "deployed",
    )
    table = rollout_table(policy, cell, int(snakemake.wildcards.seed), real, sim)
    write_table(table, snakemake.output[0])
