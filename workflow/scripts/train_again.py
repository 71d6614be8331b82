"""Train again with a trial that passed, if there are so many."""

from t2l.artefacts import read_table, write_table
from t2l.gains import Cell
from t2l.identify.artefacts import read_parameters
from t2l.jobs import job
from t2l.rl.condition import Condition
from t2l.rl.landscape import COLUMNS, CURVE_COLUMNS, choice_of, no_curve, passed
from t2l.rl.problem import Problem
from t2l.rl.settings import Search, Settings

with job(snakemake):
    params, wildcards = snakemake.params, snakemake.wildcards
    cell, seed = Cell.from_name(wildcards.cell), int(wildcards.seed)
    trials = read_table(snakemake.input.trials, COLUMNS)
    good = passed(trials, params.landscape["passed"], params.landscape["configurations"])
    rank = int(wildcards.configuration)
    if rank > len(good):
        table = no_curve()
    else:
        # it loads torch
        from t2l.rl.learn import learn

        problem = Problem(
            Condition.from_entry(params.condition),
            cell,
            read_parameters(snakemake.input.parameters),
            rate_hz=params.rate_hz,
            horizon_s=params.horizon_s,
        )
        weights = Search.from_section(params.tuning, problem.task).reward_weights
        trial = good.iloc[rank - 1]
        choice = choice_of(trial, problem.task.robot, tuple(weights))
        settings = Settings(**params.settings).of_policy(
            f"{wildcards.condition} trial {trial.number:.0f}", cell, seed
        )
        history = learn(problem, choice, settings, threads=snakemake.threads).history
        table = history.assign(configuration=int(trial.number), seed=seed, kp=cell.kp, kd=cell.kd)
    write_table(table[list(CURVE_COLUMNS)], snakemake.output[0])
