"""A batch of simulations on a GPU, by MuJoCo Warp, with what t2l uses of `mujoco.batch.Batch`.

State, controls and parameters are torch tensors of single precision that share the simulation's
memory: what is written to them acts at the next step. Worlds do not touch each other.

    batch = WarpBatch(model, 512, "cuda")
    batch.expand("actuator_gainprm")[:, 0, 0] = torch.linspace(16, 512, 512)
    batch.ctrl[:] = batch.qpos
    batch.step()

Warp compiles for the processor too (`"cpu"`), slowly; that serves to test.
"""

from collections.abc import Sequence

import mujoco
import mujoco_warp
import numpy as np
import torch
import warp

from t2l.errors import ConfigurationError

# Newton's method comes down to what single precision resolves within these; the study's arms
# without contacts need two or three
ITERATIONS, TOLERANCE = 10, 1e-6


def may_touch(model: mujoco.MjModel) -> bool:
    """Whether any two geoms of a model, of different bodies, collide."""
    if model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_CONTACT:
        return False
    kind, affinity = model.geom_contype, model.geom_conaffinity
    meets = (kind[:, None] & affinity[None]) | (affinity[:, None] & kind[None])
    return bool(np.any(meets.astype(bool) & (model.geom_bodyid[:, None] != model.geom_bodyid)))


# what `set_const` derives from the parameters of each world
_DERIVED = ("dof_invweight0", "body_invweight0")


class WarpBatch:
    """`nsim` simulations of a model without contacts.

    Attributes:
        model: as it was compiled.
        qpos, qvel, ctrl: (nsim, …) float32.
    """

    def __init__(self, model: mujoco.MjModel, nsim: int, device: str):
        """Put simulations on a device, such as `cuda` or `cuda:1`.

        Raises:
            ConfigurationError: things of the model may touch.
        """
        if may_touch(model):
            raise ConfigurationError(
                f"simulations on {device}: found a model with contacts; allowed: one without, or "
                "the processor"
            )
        warp.config.quiet = True
        warp.init()
        self.model, self.nsim, self._graph = model, nsim, None
        self._device = warp.get_device(device)
        self._torch_device = warp.device_to_torch(self._device)
        # a constraint for each joint's friction and each end of its range; no contacts
        rows = 2 * model.nv + model.njnt
        with warp.ScopedDevice(self._device):
            self._model = mujoco_warp.put_model(model)
            self._data = mujoco_warp.make_data(model, nworld=nsim, nconmax=1, njmax=rows)
        # where torch works too, so that neither overtakes the other; a processor has none
        self._stream = warp.stream_from_torch(self._torch_device) if self._device.is_cuda else None
        option = self._model.opt
        option.solver = mujoco.mjtSolver.mjSOL_NEWTON.value
        option.iterations = min(option.iterations, ITERATIONS)
        option.tolerance.fill_(TOLERANCE)
        option.warn_overflow = 0
        self.qpos, self.qvel, self.ctrl = (
            warp.to_torch(getattr(self._data, name)) for name in ("qpos", "qvel", "ctrl")
        )
        self._warmstart = warp.to_torch(self._data.qacc_warmstart)
        self._time = warp.to_torch(self._data.time)
        self._initial = self.asarray(model.qpos0)
        self.reset()

    def asarray(self, values: np.ndarray) -> torch.Tensor:
        """Numbers on the device, in single precision."""
        return torch.as_tensor(np.asarray(values, dtype=np.float32), device=self._torch_device)

    def expand(self, name: str) -> torch.Tensor:
        """A parameter with a value for each simulation, (nsim, …), to be written to."""
        shared = getattr(self._model, name)
        if shared.shape[0] != self.nsim:
            with warp.ScopedDevice(self._device):
                own = warp.empty((self.nsim, *shared.shape[1:]), dtype=shared.dtype)
            warp.to_torch(own)[:] = warp.to_torch(shared)
            setattr(self._model, name, own)
            # it holds where its arguments lay
            self._graph = None
        return warp.to_torch(getattr(self._model, name))

    def set_const(self) -> None:
        """Derive what follows from parameters that were changed."""
        for name in _DERIVED:
            self.expand(name)
        inertia = mujoco_warp.SetConstGroup.INERT0
        with warp.ScopedStream(self._stream):
            mujoco_warp.set_const(self._model, self._data, groups=inertia)

    def reset(self, ids: Sequence[int] | slice = slice(None), stage: int = 0) -> None:
        """Put simulations at the model's initial state; nothing is derived at any `stage`."""
        self.qpos[ids] = self._initial
        for values in (self.qvel, self.ctrl, self._warmstart, self._time):
            values[ids] = 0.0

    def step(self) -> None:
        """Advance all simulations by a timestep."""
        if self._stream is None:
            mujoco_warp.step(self._model, self._data)
            return
        if self._graph is None:
            self._graph = self._captured()
        warp.capture_launch(self._graph, stream=self._stream)

    def _captured(self) -> "warp.Graph":
        """A step as one launch. Its kernels are loaded by a step that is taken back."""
        moving = (self.qpos, self.qvel, self._warmstart, self._time)
        before = [values.clone() for values in moving]
        with warp.ScopedStream(self._stream):
            mujoco_warp.step(self._model, self._data)
        for values, kept in zip(moving, before, strict=True):
            values[:] = kept
        torch.cuda.synchronize(self._torch_device)
        # torch's own stream cannot be captured
        own = warp.Stream(self._device)
        with warp.ScopedStream(own), warp.ScopedCapture(stream=own) as capture:
            mujoco_warp.step(self._model, self._data)
        return capture.graph
