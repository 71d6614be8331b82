"""Train a policy with what was chosen for a cell, from a seed of its own."""

from t2l.artefacts import write_table
from t2l.identify.artefacts import read_parameters
from t2l.jobs import job
from t2l.policies import checkpoint
from t2l.rl.chosen import read_chosen, write_outcome
from t2l.rl.condition import Condition
from t2l.rl.learn import learn_and_judge
from t2l.rl.problem import Problem
from t2l.rl.settings import Settings

with job(snakemake):
    params, output = snakemake.params, snakemake.output
    cell, choice = read_chosen(snakemake.input.chosen)
    seed = int(snakemake.wildcards.seed)
    problem = Problem(
        Condition.from_entry(params.condition),
        cell,
        read_parameters(snakemake.input.parameters),
        rate_hz=params.rate_hz,
        horizon_s=params.horizon_s,
    )
    settings = Settings(**params.settings).of_policy(problem.condition.name, cell, seed)
    trained, evaluation, gain = learn_and_judge(problem, choice, settings, snakemake.threads)
    history = trained.history.assign(kp=cell.kp, kd=cell.kd, seed=seed)
    write_table(history, output.training)
    checkpoint.save(trained.policy, output.policy)
    write_outcome(output.outcome, evaluation, gain)
