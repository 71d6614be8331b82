"""What demonstrations leave unexplained, whatever the gains: residuals of each joint of each task.

`python -m benchmarks labels [TASK …]` writes docs/data/label_residuals.csv, one row a task,
joint and kind of labels; rows of other tasks stay. Demonstrations are drawn here: no policy was
trained on them.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

import mujoco
import numpy as np
import pandas as pd

from benchmarks import one_core
from benchmarks.scene import ROOT, task_file
from t2l.advise.beforehand import PAIRS, RESIDUALS, residuals
from t2l.artefacts import write_text
from t2l.demos.demonstration import Demonstration
from t2l.demos.expert import demonstrate
from t2l.sim.batch import TIMESTEP_S
from t2l.tasks import Task, make_task

TABLE = ROOT / "docs/data/label_residuals.csv"
TASKS = (
    "block_stack", "dishrack_loading", "dishrack_unloading", "bimanual_handover", "mug_hanging",
    "dishwasher",
)  # fmt: skip
ELSE = ("block_stack_ur5e",)  # in files of their own, as the six are compared with each other
DEMONSTRATIONS = 100  # as policies of every grid had
LABELS = {"positions": False, "displacements": True}
SEED = 1000  # of no study
HOLD_S, CHUNK = 0.02, 10  # of policies at 50 Hz
STATES = 4000  # that are asked for
INERTIAS = 50  # states of each demonstration that the mean inertia is of, at most


def main(arguments: Sequence[str]) -> pd.DataFrame:
    """What the command line asks for: the table, which is written too."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks labels", description=__doc__)
    parser.add_argument("tasks", nargs="*", metavar="TASK", help="of six (default: all)")
    parser.add_argument("--out", type=Path, default=TABLE, help="the table's file")
    given = parser.parse_args(arguments)
    unknown = sorted(set(given.tasks) - {*TASKS, *ELSE})
    if unknown:
        parser.error(f"found {', '.join(unknown)}; allowed: {', '.join((*TASKS, *ELSE))}")
    table = pd.read_csv(given.out) if given.out.exists() else pd.DataFrame({"task": []})
    chosen = given.tasks or TASKS
    for name, found in zip(chosen, one_core.each(rows, chosen, 1), strict=True):
        table = pd.concat([table[table.task != name], pd.DataFrame(found)])
        write_text(table.to_csv(index=False, float_format="%.6g"), given.out)
        print(f"{name} is written", flush=True)
    return table


def rows(name: str) -> list[dict]:
    """One of each joint of a task and kind of labels."""
    task = make_task(task_file(name))
    rng = np.random.default_rng(SEED)
    shown = demonstrate(task, DEMONSTRATIONS, 3 * DEMONSTRATIONS, rng)
    every = round(HOLD_S / TIMESTEP_S)
    states = [np.concatenate([d.qpos, d.dq], axis=1)[:-1:every] for d in shown]
    recorded = [
        np.stack([d.qpos[:, task.arm_qpos], d.torque, d.dq], axis=-1)[:-1:every] for d in shown
    ]
    count = sum(len(one) for one in states)
    inertia = np.mean([inertias(task, one) for one in shown], axis=0)
    found = []
    for kind, displacements in LABELS.items():
        c = residuals(states, recorded, CHUNK, max(1, count // STATES), displacements)
        found += [
            {"task": name, "labels": kind, "demonstrations": len(shown), "joint": joint,
             "inertia_kg_m2": inertia[j],
             **{key: c[j, i, k] for key, (i, k) in zip(RESIDUALS, PAIRS, strict=True)}}
            for j, joint in enumerate(task.robot.joints)
        ]  # fmt: skip
    return found


def inertias(task: Task, shown: Demonstration) -> np.ndarray:
    """(njoint,) kg·m² about each joint, the others held: mean over a demonstration."""
    data, found = mujoco.MjData(task.model), []
    full = np.zeros((task.model.nv, task.model.nv))
    for qpos in shown.qpos[:: max(1, len(shown) // INERTIAS)]:
        data.qpos[:] = qpos
        mujoco.mj_forward(task.model, data)
        mujoco.mj_fullM(task.model, data, full)
        found.append(np.diag(full)[task.arm_dofs])
    return np.mean(found, axis=0)
