"""A batch of simulations on a GPU, by MuJoCo Warp, with what t2l uses of `mujoco.batch.Batch`.

State, controls and parameters are torch tensors of single precision that share the simulation's
memory: what is written to them acts at the next step. Worlds do not touch each other.

    batch = WarpBatch(model, 512, "cuda")
    batch.expand("actuator_gainprm")[:, 0, 0] = torch.linspace(16, 512, 512)
    batch.ctrl[:] = batch.qpos
    batch.step()

Contacts are kept in memory of a fixed size. One that has no room would be lost: `diverged` says so.

Warp compiles for the processor too (`"cpu"`), slowly; that serves to test.
"""

from collections.abc import Callable, Sequence

import mujoco
import mujoco_warp
import numpy as np
import torch
import warp
from mujoco_warp import OverflowType

from t2l.errors import ConfigurationError, T2LError

# Newton's method comes down to what single precision resolves within these; the study's arms
# without contacts need two or three
ITERATIONS, TOLERANCE = 10, 1e-6
# numerics: room for the contacts of a world, and how many rows each may take. A hand at a table has
# up to 22 under random actions; a pad that presses and turns has six rows
CONTACTS, ROWS = 32, 6
# a contact or a constraint that had no room
LOST = OverflowType.NEFC | OverflowType.BROADPHASE | OverflowType.NARROWPHASE | OverflowType.CCD
# what kinematics alone bring up to date
POSITIONS = ("xpos", "xquat", "xmat", "site_xpos", "site_xmat")
# what a step leaves, of the state before it, as in MuJoCo
STEPPED = ("sensordata", "qacc", "actuator_force")


class ContactOverflowError(T2LError):
    """A world has more contacts than there is room for."""


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
    """`nsim` simulations of a model.

    Attributes:
        model: as it was compiled.
        contacts: that each of the simulations has room for.
        qpos, qvel, ctrl: (nsim, …) float32.
    """

    def __init__(self, model: mujoco.MjModel, nsim: int, device: str, contacts: int = CONTACTS):
        """Put simulations on a device, such as `cuda` or `cuda:1`.

        Raises:
            ConfigurationError: there is no such device.
        """
        warp.config.quiet = True
        warp.init()
        self.model, self.nsim, self.contacts = model, nsim, contacts if may_touch(model) else 0
        self._device = _device(device)
        self._torch_device = warp.device_to_torch(self._device)
        self._graphs: dict[Callable, warp.Graph] = {}
        # a constraint for each joint's friction and each end of its range, and those of contacts
        rows = 2 * model.nv + model.njnt + ROWS * self.contacts
        with warp.ScopedDevice(self._device):
            self._model = mujoco_warp.put_model(model)
            self._data = mujoco_warp.make_data(
                model, nworld=nsim, nconmax=max(1, self.contacts), njmax=rows
            )
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
        self._overflow = warp.to_torch(self._data.overflow)
        self._initial = self.asarray(model.qpos0)
        self.reset()

    @property
    def state(self) -> tuple[torch.Tensor, ...]:
        """What the next step depends on besides parameters, (nsim, …) each, to be written to."""
        return self.qpos, self.qvel, self.ctrl, self._warmstart, self._time

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
            # they hold where their arguments lay
            self._graphs.clear()
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

    def bind(self, name: str) -> torch.Tensor:
        """A field of `mujoco.batch.Batch.bind`, (nsim, …): state, `POSITIONS` or `STEPPED`.

        Raises:
            ValueError: nothing here brings it up to date.
        """
        if name in ("qpos", "qvel", "ctrl"):
            return getattr(self, name)
        if name not in (*POSITIONS, *STEPPED):
            allowed = ", ".join(("qpos", "qvel", "ctrl", *POSITIONS, *STEPPED))
            raise ValueError(f"field: found {name}; allowed on {self._device}: {allowed}")
        field = warp.to_torch(getattr(self._data, name))
        return field.flatten(2) if name.endswith("mat") else field

    def forward(self, stage: int = mujoco.mjtStage.mjSTAGE_POS.value) -> None:
        """Bring `POSITIONS` up to date with qpos; nothing beyond, whatever the `stage`."""
        self._launch(mujoco_warp.kinematics)

    def step(self) -> None:
        """Advance all simulations by a timestep."""
        self._launch(mujoco_warp.step)

    def diverged(self) -> np.ndarray:
        """Which simulations are no longer finite, or beyond MuJoCo's bound, (nsim,) bool.

        Raises:
            ContactOverflowError: contacts were lost since the beginning.
        """
        bound = mujoco.mjMAXVAL
        states = torch.cat([self.qpos, self.qvel], dim=1).abs()
        # no number is not below it either
        bad = ~(states < bound).all(dim=1)
        bad, full = torch.stack([bad, (self._overflow & int(LOST)) != 0]).cpu().numpy()
        # what is no number touches what it likes
        full &= ~bad
        if full.any():
            raise ContactOverflowError(
                f"contacts on {self._device}: found {full.sum()} of {self.nsim} simulations with "
                f"more than {self.contacts} contacts or {self._data.njmax} rows of constraints; "
                "allowed: up to them; simulate on the processor, or in simpler shapes"
            )
        return bad

    def _launch(self, what: Callable) -> None:
        """Run a function of MuJoCo Warp on all simulations, as one launch where that can be."""
        if self._stream is None:
            with warp.ScopedDevice(self._device):
                what(self._model, self._data)
            return
        if what not in self._graphs:
            self._graphs[what] = self._captured(what)
        warp.capture_launch(self._graphs[what], stream=self._stream)

    def _captured(self, what: Callable) -> "warp.Graph":
        """A function as one launch. Its kernels are loaded by a run that is taken back."""
        moving = (self.qpos, self.qvel, self._warmstart, self._time)
        before = [values.clone() for values in moving]
        with warp.ScopedStream(self._stream):
            what(self._model, self._data)
        for values, kept in zip(moving, before, strict=True):
            values[:] = kept
        torch.cuda.synchronize(self._torch_device)
        # torch's own stream cannot be captured
        own = warp.Stream(self._device)
        with warp.ScopedStream(own), warp.ScopedCapture(stream=own) as capture:
            what(self._model, self._data)
        return capture.graph


def _device(name: str) -> "warp.Device":
    """A device of this machine.

    Raises:
        ConfigurationError: it has none of this name.
    """
    try:
        return warp.get_device(name)
    except (RuntimeError, ValueError):
        found = ", ".join(device.alias for device in warp.get_devices())
        raise ConfigurationError(
            f"device of the simulations: found {name}, which this machine has not; allowed: "
            f"mujoco, {found}"
        ) from None
