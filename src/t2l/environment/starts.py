"""Whether episodes can begin where a task puts things: none inside another."""

import mujoco
import numpy as np

from t2l.errors import ConfigurationError
from t2l.tasks import Task

# starts that are tried, and how far contacts may be in one another: soft ones yield by less
TRIED = 64
DEEPEST_M = 2e-3


def check_starts(task: Task) -> None:
    """Try some starts.

    Raises:
        ConfigurationError: something starts inside something else.
    """
    model, data = task.model, mujoco.MjData(task.model)
    for qpos in task.sample_starts(np.random.default_rng(0), TRIED):
        data.qpos[:] = qpos
        mujoco.mj_fwdPosition(model, data)
        depth_m = -data.contact.dist
        if not depth_m.size or depth_m.max() < DEEPEST_M:
            continue
        worst = int(depth_m.argmax())
        one, other = (_name(model, geom) for geom in data.contact.geom[worst])
        raise ConfigurationError(
            f"starts of {task.name}: found {other} {1000 * depth_m[worst]:.3g} mm inside {one}; "
            "allowed: things apart; change where the robot or the objects start"
        )


def _name(model: mujoco.MjModel, geom: int) -> str:
    """What a reader knows a geom by: its body, which has a name."""
    return model.body(model.geom(geom).bodyid[0]).name
