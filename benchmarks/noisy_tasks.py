"""What each task forgives: replays under the same noise, in compliant and in stiff cells.

`python -m benchmarks noisy_tasks [TASK …]` writes docs/data/noisy_tasks.csv, one row a task and
overdamped cell of the collections; rows of other tasks stay. Demonstrations are drawn here.

The rule, written before the first run. Does what a task forgives tell where compliance helps beside
damping? The unit is the task, n = 6. Of each: success under noise at CO less that at SO, and in
collections after 150 epochs success of policies at CO less that at SO. It tells where Spearman's ρ
over tasks is above 0, one-sided (α 0.05: ρ of 0.83 at least); else it cannot be told. Besides: in
the dishwasher, where SO is ahead, SO should then stand more noise than in any other task.
"""

import argparse
from collections.abc import Sequence

import pandas as pd

from benchmarks.labels import DEMONSTRATIONS, HOLD_S, SEED, TASKS
from benchmarks.scene import ROOT, task_file
from t2l.actions import make_control
from t2l.artefacts import write_text
from t2l.demos.expert import demonstrate
from t2l.gains import Cell
from t2l.seeds import generator
from t2l.sim.batch import TIMESTEP_S
from t2l.study.attenuation.noise import noisy_replays
from t2l.tasks import make_task
from t2l.threads import one_thread

TABLE = ROOT / "docs/data/noisy_tasks.csv"
CELLS = [Cell(kp, kd) for kp in (32.0, 128.0, 512.0, 2048.0) for kd in (32.0, 128.0)]
NOISE_RAD = 0.049  # at most: as large as in the replays of Block Stack
REPLAYS = 50  # of each cell


def main(arguments: Sequence[str]) -> pd.DataFrame:
    """What the command line asks for: the table, which is written too."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks noisy_tasks")
    parser.add_argument("tasks", nargs="*", metavar="TASK", help="of six (default: all)")
    tasks = parser.parse_args(arguments).tasks or TASKS
    if unknown := sorted(set(tasks) - set(TASKS)):
        parser.error(f"found {', '.join(unknown)}; allowed: {', '.join(TASKS)}")
    one_thread()
    table = pd.read_csv(TABLE) if TABLE.exists() else pd.DataFrame({"task": []})
    for name in tasks:
        found = pd.DataFrame(rows(name))
        # beside nothing, whole numbers would become others
        table = pd.concat([table[table.task != name], found]) if len(table) else found
        write_text(table.to_csv(index=False), TABLE)
        print(f"{name} is written", flush=True)
    return table


def rows(name: str) -> list[dict[str, object]]:
    """One a cell. The noise is the same in every cell."""
    task = make_task(task_file(name))
    shown = demonstrate(task, DEMONSTRATIONS, 3 * DEMONSTRATIONS, generator(SEED, name))
    found = []
    for cell in CELLS:
        control = make_control({"kind": "joint_target"}, cell, task.robot, task.model)
        how = control, round(HOLD_S / TIMESTEP_S), "sample", NOISE_RAD, REPLAYS
        replays = noisy_replays(task, shown, *how, generator(SEED, "noise", name))
        found.append(
            {
                "task": name, "kp": int(cell.kp), "kd": int(cell.kd), "noise_rad": NOISE_RAD,
                "replays": len(replays), "successes": sum(bool(one.success) for one in replays),
            }
        )  # fmt: skip
    return found
