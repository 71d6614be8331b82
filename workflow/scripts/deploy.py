"""Run a cell's policy on the robot and in its simulator, from matched starts and goals."""

from pathlib import Path

from t2l.artefacts import write_table
from t2l.environment.interface import action_space, observation_names
from t2l.gains import Cell
from t2l.identify.artefacts import read_parameters
from t2l.jobs import job
from t2l.policies import checkpoint
from t2l.rl.problem import Condition
from t2l.transfer.errors import observation_table, rollout_table, trace_table
from t2l.transfer.matched import Deployment, matched_rollouts

with job(snakemake):
    params, cell = snakemake.params, Cell.from_name(snakemake.wildcards.cell)
    policy = checkpoint.load(snakemake.input.policy)
    condition = Condition.from_entry(params.condition)
    task = condition.make_task()
    real, sim = matched_rollouts(
        params.robot,
        policy,
        condition,
        cell,
        read_parameters(snakemake.input.parameters),
        Deployment.from_section(params.deployment, params.horizon_s, params.rate_hz),
        params.seed,
        Path(snakemake.output.rollouts).parent / "deployed",
    )
    write_table(trace_table(real, sim, task.robot.joints), snakemake.output.traces)
    actions = action_space(condition.actions, task.robot, policy.action_scale)
    seen = observation_table(real, sim, observation_names(task, actions))
    write_table(seen, snakemake.output.observations)
    seed = int(snakemake.wildcards.seed)
    write_table(rollout_table(policy, cell, seed, real, sim), snakemake.output.rollouts)
