"""What a retargeted demonstration commanded, and where the robot was."""

import mujoco
import numpy as np

from t2l.actions import Control
from t2l.sim import make_batch
from t2l.tasks import Task


def tracked(
    task: Task, control: Control, observation: np.ndarray, action: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Commands and what they are about, (n, ncommand) each.

    Args:
        observation: (n, nobs), which begins with q.
        action: (n, naction + ngripper) as policies give it, with grippers.
    """
    n, controller = len(observation), control.controller
    batch = make_batch(task.model, n)
    controller.install(batch)
    batch.qpos[:, task.arm_qpos] = observation[:, : task.arm_qpos.size]
    batch.forward(stage=mujoco.mjtStage.mjSTAGE_POS.value)
    measured = controller.measured(batch)
    command = np.empty_like(measured)
    before = measured[:1]
    for k in range(n):
        own = action[k : k + 1, : len(control.actions.names)]
        before = command[k : k + 1] = control.actions.command(own, measured[k : k + 1], before)
    return command, measured
