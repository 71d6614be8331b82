"""A step of all commands, simulated with the effects of a model."""

import numpy as np

from t2l.identify.model import Model
from t2l.identify.prediction import with_effects
from t2l.identify.simulation import made_loop
from t2l.sim.schedule import Schedule


def stepped(
    model: Model,
    joints: tuple[str, ...],
    pose: np.ndarray,
    kp: np.ndarray,
    kd: np.ndarray,
    size: np.ndarray,
    rate_hz: float,
    seconds: float,
    substeps: int = 8,
) -> np.ndarray:
    """(ntick, n) rad from where it is without the step, which comes at the first tick.

    The weight is carried.
    """
    ticks = round(seconds * rate_hz)
    commands = np.tile(np.stack([pose, pose + size]), (ticks + 1, 1, 1))
    # a delay line begins with the first command that it is given
    commands[0] = pose
    layout, u = model.vector(joints)
    extending = [term for term in layout.terms if term.effect.extends]
    schedule = Schedule(
        period_s=1 / rate_hz, commands=commands, kp=np.stack([kp] * 2),
        kd=np.stack([kd] * 2), start_q=np.stack([pose] * 2), start_dq=np.zeros((2, len(pose))),
        compensated=np.zeros(2, bool), balanced=np.ones(2, bool), sample_ticks=np.arange(ticks + 1),
    )  # fmt: skip
    compiled = with_effects(model.robot, joints, extending)
    loop = made_loop(compiled, joints, schedule, substeps, [(layout, u[None])], 1)
    q, _ = loop.run()
    return q[0, 1, 1:] - q[0, 0, 1:]
