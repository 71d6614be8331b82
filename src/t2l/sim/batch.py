"""Batches of simulations and the controller gains as their per-simulation parameters.

Every model steps with MuJoCo's `discrete` integrator, which evaluates the position actuators at
the end of a step together with the constraints: the actuator's torque over the step from k to k+1
is exactly Kp (q_des − q[k+1]) − Kd q̇[k+1]. Stiff and heavily damped cells are therefore stable at
500 Hz, and the law can be inverted exactly (see `t2l.demos.retarget`).
"""

from collections.abc import Sequence
from functools import cache
from importlib.util import find_spec
from typing import TYPE_CHECKING

import mujoco
import numpy as np
from mujoco.batch import Batch, SimulationError
from numpy.typing import ArrayLike

from t2l.errors import ConfigurationError
from t2l.sim.arrays import like

if TYPE_CHECKING:
    from t2l.sim.warp_batch import WarpBatch

TIMESTEP_S = 0.002
# MuJoCo on the processor, in place of a device of torch
MUJOCO = "mujoco"


def make_batch(
    model: mujoco.MjModel, nsim: int, threads: int = 1, device: str = MUJOCO
) -> "Batch | WarpBatch":
    """A batch of `nsim` simulations of `model`.

    Args:
        threads: of the processor, which change no result.
        device: `MUJOCO`, whose arrays are NumPy's; or a device as torch names it, such as `cuda`,
            for MuJoCo Warp, whose arrays are torch's in single precision.

    Raises:
        ConfigurationError: this machine has no such device, or MuJoCo Warp is not installed.
    """
    if device != MUJOCO:
        if find_spec("mujoco_warp") is None:
            raise ConfigurationError(
                f"device of the simulations: found {device}, which wants MuJoCo Warp, and that is "
                f"not installed; allowed: pip install 't2l[gpu]', or {MUJOCO}"
            )
        from t2l.sim.warp_batch import WarpBatch

        return WarpBatch(model, nsim, device)
    _silence_warnings()
    return Batch(model, nsim, nthread=threads)


@cache
def _silence_warnings() -> None:
    """A fit tries what runs away: `diverged` reports it, where MuJoCo would fill a log file."""
    mujoco.set_mju_user_warning(lambda text: None)


def apply_position_gains(batch: Batch, joints: Sequence[str], kp: ArrayLike, kd: ArrayLike) -> None:
    """Make the actuators of `joints` position controllers; their ctrl is q_des in rad.

    Args:
        kp, kd: one number, one per simulation (nsim, 1), or one per simulation and joint
            (nsim, njoint); N·m/rad and N·m·s/rad.
    """
    ids = [batch.model.actuator(joint).id for joint in joints]
    gain, bias = batch.expand("actuator_gainprm"), batch.expand("actuator_biasprm")
    kp, kd = like(kp, gain), like(kd, gain)
    gain[:, ids, 0] = kp
    bias[:, ids, 1] = -kp
    bias[:, ids, 2] = -kd


def apply_torque_control(batch: Batch, joints: Sequence[str]) -> None:
    """Make the actuators of `joints` motors; their ctrl is a torque in N·m."""
    ids = [batch.model.actuator(joint).id for joint in joints]
    gain, bias = batch.expand("actuator_gainprm"), batch.expand("actuator_biasprm")
    gain[:, ids, 0] = 1.0
    bias[:, ids, :3] = 0.0


def diverged(batch: "Batch | WarpBatch") -> np.ndarray:
    """Which simulations raised a MuJoCo warning or are no longer finite, (nsim,) bool."""
    if not isinstance(batch, Batch):
        return batch.diverged()
    raised = (batch.warning[:, :, 1] > 0).any(axis=1)  # columns: last info, count
    return raised | ~np.isfinite(batch.state).all(axis=1)


def step(
    batch: Batch,
    running: np.ndarray,
    nstep: int = 1,
    stage: mujoco.mjtStage = mujoco.mjtStage.mjSTAGE_VEL,
) -> None:
    """Advance the `running` simulations by `nstep` timesteps and clear those that diverged.

    Args:
        running: (nsim,) bool, updated in place: a simulation that diverges or in which MuJoCo
            raises is taken out and never stepped again.
        stage: how far derived quantities are brought up to date afterwards.
    """
    if not running.any():
        return
    try:
        batch.step(ids=running, nstep=nstep, stage=stage.value)
    except SimulationError as error:
        running[error.ids] = False
    running &= ~diverged(batch)
