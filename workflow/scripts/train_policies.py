"""Train policies with what was chosen for their cells, each from a seed of its own."""

from pathlib import Path

from t2l.artefacts import write_table
from t2l.identify.artefacts import read_parameters
from t2l.jobs import job
from t2l.policies import checkpoint
from t2l.rl.alone import depends_on
from t2l.rl.problem import Condition, Problem
from t2l.rl.results import read_chosen, write_outcome
from t2l.rl.settings import Settings
from t2l.rl.side_by_side import Training, policies_of
from t2l.rl.unfinished import Unfinished

with job(snakemake):
    params, output = snakemake.params, snakemake.output
    condition, trainings = Condition.from_entry(params.condition), []
    chosen = {Path(path).parent.name: path for path in snakemake.input.chosen}
    parameters = {Path(path).parent.name: path for path in snakemake.input.parameters}
    seeds = [int(Path(path).parent.name.removeprefix("seed")) for path in output.policies]
    for path, seed in zip(output.policies, seeds, strict=True):
        name = Path(path).parent.parent.name
        cell, choice = read_chosen(chosen[name])
        problem = Problem(
            condition,
            cell,
            read_parameters(parameters[name]),
            rate_hz=params.rate_hz,
            horizon_s=params.horizon_s,
        )
        settings = Settings(**params.settings).of_policy(condition.name, cell, seed)
        # Snakemake does not know it: it outlives a job that was cut short
        unfinished = Unfinished(
            Path(path).with_name("unfinished.pt"),
            f"{params.version} {depends_on(problem, choice, settings, seed)}",
        )
        trainings.append(Training(problem, choice, settings, unfinished=unfinished))
    made = policies_of(trainings, snakemake.threads)
    for i, (trained, evaluation, gain) in enumerate(made):
        cell = trainings[i].problem.cell
        history = trained.history.assign(kp=cell.kp, kd=cell.kd, seed=seeds[i])
        write_table(history, output.training[i])
        checkpoint.save(trained.policy, output.policies[i])
        write_outcome(output.outcomes[i], evaluation, gain)
    for training in trainings:
        training.unfinished.remove()
