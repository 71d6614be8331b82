"""Train the policies of all cells of a condition, side by side, each from a seed of its own."""

from pathlib import Path

from t2l.artefacts import write_table
from t2l.identify.artefacts import read_parameters
from t2l.jobs import job
from t2l.policies import checkpoint
from t2l.rl.chosen import read_chosen, write_outcome
from t2l.rl.condition import Condition
from t2l.rl.learn import gain_of
from t2l.rl.problem import Problem
from t2l.rl.settings import Settings
from t2l.rl.side_by_side import Training, judge_side_by_side, learn_side_by_side

with job(snakemake):
    params, output = snakemake.params, snakemake.output
    condition, trainings, seeds = Condition.from_entry(params.condition), [], []
    chosen = {Path(path).parent.name: read_chosen(path) for path in snakemake.input.chosen}
    parameters = {Path(path).parent.name: path for path in snakemake.input.parameters}
    for path in output.policies:
        cell, choice = chosen[Path(path).parent.parent.name]
        seeds.append(int(Path(path).parent.name.removeprefix("seed")))
        problem = Problem(
            condition,
            cell,
            read_parameters(parameters[cell.name]),
            rate_hz=params.rate_hz,
            horizon_s=params.horizon_s,
        )
        settings = Settings(**params.settings).of_policy(condition.name, cell, seeds[-1])
        trainings.append(Training(problem, choice, settings))
    trained = learn_side_by_side(trainings, snakemake.threads)
    for one in trained:
        if isinstance(one, Exception):
            raise one
    found = judge_side_by_side(trainings, [one.policy for one in trained], snakemake.threads)
    for i, (training, one, seed) in enumerate(zip(trainings, trained, seeds, strict=True)):
        cell = training.problem.cell
        gain = gain_of(training.problem, training.choice, training.settings, one.policy)
        write_table(one.history.assign(kp=cell.kp, kd=cell.kd, seed=seed), output.training[i])
        checkpoint.save(one.policy, output.policies[i])
        write_outcome(output.outcomes[i], found[i], gain)
