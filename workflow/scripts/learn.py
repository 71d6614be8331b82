"""Learn a task in one cell from one seed, in simulation alone."""

from pathlib import Path

import pandas as pd

from t2l.artefacts import write_table
from t2l.gains import Cell
from t2l.jobs import job
from t2l.policies import checkpoint
from t2l.rl.alone import depends_on, problem_of, settings_of, train_alone
from t2l.rl.results import read_chosen
from t2l.rl.unfinished import Unfinished

with job(snakemake):
    params, wildcards, output = snakemake.params, snakemake.wildcards, snakemake.output
    cell, seed = Cell.from_name(wildcards.cell), int(wildcards.seed)
    problem, choice = problem_of(params.entry, params.task, cell)
    # an input only where the action scales are searched
    if snakemake.input:
        _, choice = read_chosen(snakemake.input.chosen)
    settings = settings_of(params.settings, params.entry)
    # Snakemake does not know it: it outlives a job that was cut short
    unfinished = Unfinished(
        Path(output.policy).with_name("unfinished.pt"),
        f"{params.version} {depends_on(problem, choice, settings, seed)}",
    )
    trained, row, episodes = train_alone(
        problem, choice, settings, seed, threads=snakemake.threads, unfinished=unfinished,
        episodes=params.episodes,
    )  # fmt: skip
    checkpoint.save(trained.policy, output.policy)
    write_table(trained.history.assign(kp=cell.kp, kd=cell.kd, seed=seed), output.training)
    write_table(pd.DataFrame([row]), output.outcome)
    write_table(episodes, output.episodes)
    unfinished.remove()
