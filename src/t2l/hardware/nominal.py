"""Motions as the nominal model makes them: the MJCF as it is, in the loop of a controller.

    τ_k = Kp (q_des − q_k) − Kd q̇_k + g(q_k),   held from tick to tick

What a robot of metal adds, such as delays and friction that no file states, is not in it.
"""

from dataclasses import dataclass

import mujoco
import numpy as np

from t2l.hardware.features import Features
from t2l.recordings.recording import CONTINUOUS
from t2l.robots import Robot, plant
from t2l.sim.sampled_loop import transition
from t2l.sim.schedule import Schedule
from t2l.sim.servo import ServoLoop

# numerics: how often the simulated state is looked at: a joint at 10 Hz 20 times a period
LOOKS_HZ = 200.0
# numerics: of a radius of eigenvalues: less is rounding
ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class Response:
    """What motions become, at about `LOOKS_HZ`; NaN after one ran away.

    Attributes:
        time: (nlook,) s.
        q_des, q, dq: (nmotion, nlook, njoint), rad and rad/s.
        torque: likewise, N·m that the law asks for, without gravity compensation and any limit.
    """

    time: np.ndarray
    q_des: np.ndarray
    q: np.ndarray
    dq: np.ndarray
    torque: np.ndarray


def respond(
    robot: Robot,
    features: Features,
    q_des: np.ndarray,
    rate_hz: float,
    kp: np.ndarray,
    kd: np.ndarray,
) -> Response:
    """Simulate motions side by side, each from rest at its first command.

    Args:
        features: whose loop rate and gravity compensation are simulated.
        q_des: (nmotion, ncommand, njoint) rad, at `rate_hz`.
        kp, kd: each broadcasts to (nmotion, njoint), N·m/rad and N·m·s/rad.
    """
    nmotion, ncommand, njoint = q_des.shape
    control_hz = features.control_rate_hz
    ticks = np.arange(round(ncommand / rate_hz * control_hz))
    # the command that is held at each tick; a whole number may be a rounding short of itself
    given = np.minimum((ticks * rate_hz / control_hz + 1e-9).astype(int), ncommand - 1)
    commands = q_des[:, given].transpose(1, 0, 2)
    kp, kd = (np.broadcast_to(gain, (nmotion, njoint)) for gain in (kp, kd))
    compensation = features.gravity_compensation
    looks = ticks[:: max(1, round(control_hz / LOOKS_HZ))]
    schedule = Schedule(
        period_s=1 / control_hz,
        commands=commands,
        kp=kp,
        kd=kd,
        start_q=q_des[:, 0],
        start_dq=np.zeros((nmotion, njoint)),
        compensated=np.full(nmotion, compensation is True),
        balanced=np.full(nmotion, compensation == CONTINUOUS),
        sample_ticks=looks,
    )
    model = plant.load(robot.name, robot.joints).compile()
    with np.errstate(over="ignore", invalid="ignore"):
        (q,), (dq,) = ServoLoop(model, robot.joints, schedule, 1, 1).run()
        wanted = commands[looks].transpose(1, 0, 2)
        torque = kp[:, None] * (wanted - q) - kd[:, None] * dq
    return Response(looks / control_hz, wanted, q, dq, torque)


@dataclass(frozen=True)
class Ringing:
    """Gains that make a loop swing by itself, ever more.

    Attributes:
        joint: index of the one that swings most.
        frequency_hz: of the swing.
        allowed: gains of that joint that do not, in words.
    """

    joint: int
    frequency_hz: float
    allowed: str


class SampledLoop:
    """The loop of a robot near a pose, linear: its gains damp every swing, or not.

    See `t2l.sim.sampled_loop`. Dry friction and gravity are left out.
    """

    def __init__(self, robot: Robot, features: Features, q: np.ndarray):
        """Linearise at q (njoint,) rad."""
        model = plant.load(robot.name, robot.joints).compile()
        data = mujoco.MjData(model)
        joints = [model.joint(name) for name in robot.joints]
        qpos, dofs = (np.array([getattr(j, a)[0] for j in joints]) for a in ("qposadr", "dofadr"))
        data.qpos[qpos] = q
        mujoco.mj_forward(model, data)
        mass = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, mass)
        self._mass, self._damping = mass[np.ix_(dofs, dofs)], model.dof_damping[dofs]
        self._stiffness = model.jnt_stiffness[[joint.id for joint in joints]]
        self._period_s = 1 / features.control_rate_hz

    def ringing(self, kp: np.ndarray, kd: np.ndarray) -> Ringing | None:
        """What swings by itself under kp N·m/rad and kd N·m·s/rad, (njoint,); None if nothing."""
        n = len(kp)
        loop = (self._mass[None], self._damping[None], self._stiffness[None])
        with np.errstate(over="ignore", invalid="ignore"):
            (step,) = transition(*loop, kp[None], kd[None], np.array([self._period_s]))
        if not np.isfinite(step).all():
            joint = int(np.argmax(np.maximum(kp, kd)))
            return Ringing(joint, 0.5 / self._period_s, self._allowed(joint, kp, kd))
        values, vectors = np.linalg.eig(step)
        worst = int(np.argmax(np.abs(values)))
        if np.abs(values[worst]) <= 1 + ROUNDING:
            return None
        joint = int(np.argmax(np.abs(vectors[n:, worst])))
        frequency = abs(np.angle(values[worst])) / (2 * np.pi * self._period_s)
        return Ringing(joint, float(frequency), self._allowed(joint, kp, kd))

    def _allowed(self, joint: int, kp: np.ndarray, kd: np.ndarray) -> str:
        h, inertia = self._period_s, 1 / np.linalg.inv(self._mass)[joint, joint]
        low, high = max(0.0, kp[joint] * h / 2 - self._damping[joint]), 2 * inertia / h
        if low >= high:
            return f"kp below {4 * inertia / h**2:.3g} N·m/rad"
        if low < kd[joint] < high:
            return "softer gains of all joints"
        return f"kd between {low:.3g} and {high:.3g} N·m·s/rad for this kp"
