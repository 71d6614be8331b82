"""A plant without what identification finds: the gains as they are, and no friction."""

import numpy as np

from t2l.gains import Cell
from t2l.sim.training_simulator import Parameters
from t2l.tasks import Task


def ideal_plant(task: Task, cell: Cell) -> Parameters:
    """Joints of the robot's own inertias, without friction, under the gains as they are.

    Friction would hold an arm against a part of every force, and be taken for stiffness.
    """
    joints = np.zeros(len(task.robot.joints))
    stiffness, damping = task.robot.gains(cell.kp, cell.kd)
    return {
        "stiffness": stiffness,
        "damping": damping,
        "armature": task.model.dof_armature[task.arm_dofs],
        "static_friction": joints,
        "dynamic_friction_ratio": joints,
        "viscous_friction": joints,
    }
