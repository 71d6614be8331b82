"""Train again with trials that passed, where there are so many."""

from pathlib import Path

from t2l.artefacts import read_table, write_table
from t2l.gains import Cell
from t2l.identify.artefacts import read_parameters
from t2l.jobs import job
from t2l.rl.problem import Condition, Problem
from t2l.rl.settings import Search, Settings
from t2l.rl.unfinished import Unfinished
from t2l.study.landscape.again import COLUMNS, CURVE_COLUMNS, choice_of, no_curve, passed

with job(snakemake):
    params, trainings, numbers = snakemake.params, {}, {}
    trials = {Path(path).parent.name: path for path in snakemake.input.trials}
    parameters = {Path(path).parent.name: path for path in snakemake.input.parameters}
    condition = Condition.from_entry(params.condition)
    for path in map(Path, snakemake.output):
        cell = Cell.from_name(path.parent.parent.name)
        rank, seed = map(int, path.stem.split("_seed"))
        table = read_table(trials[cell.name], COLUMNS)
        good = passed(table, params.landscape["passed"], params.landscape["configurations"])
        if rank > len(good):
            write_table(no_curve()[list(CURVE_COLUMNS)], path)
            continue
        # it loads torch
        from t2l.rl.alone import depends_on
        from t2l.rl.side_by_side import Training, learn_side_by_side

        problem = Problem(
            condition,
            cell,
            read_parameters(parameters[cell.name]),
            rate_hz=params.rate_hz,
            horizon_s=params.horizon_s,
        )
        weights = Search.from_section(params.tuning, problem.task).reward_weights
        trial = good.iloc[rank - 1]
        choice = choice_of(trial, problem.task.robot, tuple(weights))
        settings = Settings(**params.settings).of_policy(
            f"{condition.name} trial {trial.number:.0f}", cell, seed
        )
        # Snakemake does not know it: it outlives a job that was cut short
        unfinished = Unfinished(
            path.with_suffix(".unfinished.pt"),
            f"{params.version} {depends_on(problem, choice, settings, seed)}",
        )
        trainings[path] = Training(problem, choice, settings, unfinished=unfinished)
        numbers[path] = trial.number, seed
    trained = learn_side_by_side(list(trainings.values()), snakemake.threads) if trainings else []
    for (path, training), one in zip(trainings.items(), trained, strict=True):
        if isinstance(one, Exception):
            raise one
        (number, seed), cell = numbers[path], training.problem.cell
        table = one.history.assign(configuration=int(number), seed=seed, kp=cell.kp, kd=cell.kd)
        write_table(table[list(CURVE_COLUMNS)], path)
    for training in trainings.values():
        training.unfinished.remove()
