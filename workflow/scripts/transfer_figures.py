"""Draw how far policies on the robot depart from their simulators."""

from t2l.artefacts import read_table
from t2l.figures import transfer
from t2l.gains import Grid
from t2l.jobs import job
from t2l.plotting.style import write
from t2l.transfer.summary import best_and_worst, over_seeds

with job(snakemake):
    given, output = snakemake.input, snakemake.output
    grid = Grid.from_section(snakemake.params.grid)
    policies = [tuple(each) for each in snakemake.params.policies]
    cells = {
        condition: over_seeds(read_table(path, transfer.CELL_COLUMNS))
        for condition, path in zip(snakemake.params.conditions, given.cells, strict=True)
    }
    write(transfer.error_maps(cells, grid), output.errors)

    rollouts = read_table(given.rollouts[0], ("kp", "kd", "seed", "rollout", "trajectory_error"))
    traces, observations, captions = {}, {}, []
    for word, (cell, seed, rollout, error) in best_and_worst(rollouts).items():
        at = policies.index((cell.name, seed))
        trace = read_table(given.traces[at], transfer.TRACE_COLUMNS)
        traces[cell] = trace[trace.rollout == rollout]
        observations[cell] = read_table(given.observations[at], transfer.OBSERVATION_COLUMNS)
        captions.append(f"{word} of the cells, E = {error:.2g}")
    write(transfer.wrist_trajectories(traces, captions), output.wrist)
    write(transfer.observation_distributions(observations), output.observations)
