"""Every benchmark in turn: `make bench`, or some by name: `python -m benchmarks throughput`.

`python -m benchmarks hidden [CASE …] [--processes N] [--earlier TABLE]` takes some cases, and
puts an earlier table's errors and times beside the new ones. `python -m benchmarks proposals
[CASE …] [--processes N]` takes some cases too, `python -m benchmarks holdouts [CHOICE …]
[--processes N]` some choices. `python -m benchmarks earlier --checkout FOLDER` needs a checkout,
`python -m benchmarks machines --data FOLDER` recordings of real machines, as `following` does.
`planted_worlds {train,judge} {development,test}` takes a half of its worlds.
`python -m benchmarks labels [TASK …]` takes some tasks, as `learning_periods` and
`noisy_tasks` do, `collections [RESULTS]` results of a run,
`from_truth [CASE …]` cases as `hidden`, `engines [DEVICE …]` engines: `mujoco`,
`cuda`, or `cpu` of MuJoCo Warp. `existence train FOLDER TASK`, `existence judge FOLDER` and
`existence show FOLDER` say more by `--help`.
"""

import sys

from benchmarks import (
    advice,
    cell,
    collections,
    constants,
    diagnosis,
    earlier,
    engines,
    existence,
    following,
    from_truth,
    hidden,
    holdouts,
    labels,
    learning_periods,
    machines,
    noisy_tasks,
    overhead,
    planted_worlds,
    proposals,
    published,
    reinforcement,
    rival,
    rules,
    servo,
    throughput,
    training,
)

BENCHMARKS = {
    module.__name__.split(".")[-1]: module
    for module in (
        throughput,
        training,
        cell,
        overhead,
        reinforcement,
        diagnosis,
        hidden,
        proposals,
        holdouts,
        published,
        rival,
        servo,
        rules,
        constants,
    )
}
WITH_ARGUMENTS = {
    "advice": advice,
    "hidden": hidden,
    "from_truth": from_truth,
    "proposals": proposals,
    "holdouts": holdouts,
    "earlier": earlier,
    "engines": engines,
    "existence": existence,
    "machines": machines,
    "following": following,
    "labels": labels,
    "learning_periods": learning_periods,
    "noisy_tasks": noisy_tasks,
    "collections": collections,
    "planted_worlds": planted_worlds,
    "constants": constants,
}


def main(names: list[str]) -> None:
    """Print a Markdown table per benchmark: what, measured, baseline of the same run, ratio."""
    if names and (module := WITH_ARGUMENTS.get(names[0])):
        print(module.main(names[1:]).to_markdown(index=False))
        return
    unknown = set(names) - set(BENCHMARKS)
    if unknown:
        sys.exit(f"no benchmark {', '.join(unknown)}; there are {', '.join(BENCHMARKS)}")
    for name in names or BENCHMARKS:
        module = BENCHMARKS[name]
        print(f"\n## {name}: {module.__doc__.splitlines()[0]}\n", flush=True)
        print(module.run().to_markdown(index=False), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
