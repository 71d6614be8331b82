"""Train with a cell's chosen action scales from another seed, if they passed."""

from t2l.artefacts import write_table
from t2l.identify.artefacts import read_parameters
from t2l.jobs import job
from t2l.rl.chosen import read_chosen
from t2l.rl.condition import Condition
from t2l.rl.problem import Problem
from t2l.rl.settings import Settings
from t2l.rl.training_curves import curve, no_curve

with job(snakemake):
    params = snakemake.params
    cell, choice, evaluation = read_chosen(snakemake.input.chosen)
    seed = int(snakemake.wildcards.seed)
    settings = Settings(**{**params.settings, "seed": seed})
    problem = Problem(
        Condition.from_entry(params.condition),
        cell,
        read_parameters(snakemake.input.parameters),
        rate_hz=params.rate_hz,
        horizon_s=params.horizon_s,
    )
    passed = evaluation.objective >= 1 and evaluation.success >= params.passed
    table = curve(problem, choice, settings, snakemake.threads) if passed else no_curve()
    write_table(table.assign(kp=cell.kp, kd=cell.kd, seed=seed), snakemake.output[0])
