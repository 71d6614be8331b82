"""A model whose loop chatters at its own rate, found by algebra before anything is simulated.

No real machine does so. What its log holds then belongs to another robot than the model: one of
more inertia, of another Kd, or of a faster loop. No effect but that one can be told from it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from t2l.errors import ConfigurationError
from t2l.identify.model import Model
from t2l.identify.prediction import with_effects
from t2l.identify.schedules import FOLLOWED
from t2l.identify.simulation import made_loop
from t2l.recordings.recording import Recording
from t2l.sim.sampled_loop import chatter, damping_number, stiffness_number, transition
from t2l.sim.schedule import Schedule

POSES = 64  # numerics: of all recordings together; inertia changes slowly from pose to pose
LEAST_POSES = 2  # numerics: of each recording
# bound: a disturbance of 1 µrad, which every encoder has, grows to 1 rad
GROWN = 1e6
HALVINGS = 12  # numerics: the least armature to a part in 4000


@dataclass(frozen=True)
class Chatter:
    """A loop of a model that chatters.

    Attributes:
        recording, joint: where most.
        kp, kd, control_rate_hz: of that.
        inertia: kg·m² that the joint moves in that motion.
        armature: by joint, the least that the effect `armature` must have for no loop to chatter; a
            joint that needs none has as little as any, so that it is fitted too.
    """

    recording: str
    joint: str
    kp: float
    kd: float
    control_rate_hz: float
    inertia: float
    armature: dict[str, float]

    @property
    def message(self) -> str:
        """Which joint, which gain, which rate; the number, and what it must be."""
        period = 1 / self.control_rate_hz
        damps, holds = self.kd * period / self.inertia, self.kp * period**2 / self.inertia
        number = f"Kd·h/M is {damps:.3g} and must be below 2"
        if damps < 2:
            number = f"Kp·h²/M is {holds:.3g} and must be below 2·Kd·h/M, which is {2 * damps:.3g}"
        return (
            f"The model cannot be simulated: its loop chatters at its own rate on joint "
            f"{self.joint} in {self.recording}. {number} (Kp {self.kp:g} N·m/rad, Kd {self.kd:g} "
            f"N·m·s/rad, h = 1/{self.control_rate_hz:g} s by control_rate_hz, inertia M = "
            f"{self.inertia:.3g} kg·m²)."
        )

    @property
    def advice(self) -> str:
        """What is usually wrong, and a line of YAML."""
        # of 3e-05 YAML makes a string
        values = ", ".join(
            f"{joint}: {np.format_float_positional(value, trim='0')}"
            for joint, value in self.armature.items()
        )
        return (
            "First make sure that Kp and Kd are in N·m/rad and N·m·s/rad, no registers, and that "
            "control_rate_hz is the rate of the loop, not that of the log. If so, the armature is "
            "missing, the inertia of rotor and gears, which a URDF cannot hold: put at least this "
            "into a file for --model, beside the line of its robot: effects: {armature: "
            f"{{inertia: {{{values}}}}}}}"
        )

    @property
    def sentence(self) -> str:
        """Both, for people."""
        return f"{self.message} {self.advice}"


@dataclass(frozen=True)
class Loops:
    """Poses of controlled joints.

    Attributes:
        names: (k,) of what each is of.
        kp, kd, q: (k, njoint) N·m/rad, N·m·s/rad, rad.
        rate_hz: (k,) of the control loop.
        ticks: (k,) how long it goes on.
        logged: columns that effects follow, (k, njoint) each.
    """

    names: list[str]
    kp: np.ndarray
    kd: np.ndarray
    q: np.ndarray
    rate_hz: np.ndarray
    ticks: np.ndarray
    logged: dict[str, np.ndarray]


def check_settles(model: Model, recordings: Sequence[Recording]) -> None:
    """Find a model that is not worth fitting, as its loop chatters.

    Raises:
        ConfigurationError: it does, with what to do.
    """
    found = chattering(model, recordings)
    if found is not None:
        raise ConfigurationError(found.sentence)


def chattering(model: Model, recordings: Sequence[Recording]) -> Chatter | None:
    """Where the model's loop chatters most under the recordings' gains, in poses that they have.

    None where it does not, or where effects of the model change the loop itself, as a filter does.
    """
    return of_loops(model, recordings[0].joints, poses(recordings))


def poses(recordings: Sequence[Recording]) -> Loops:
    """Of every recording a few poses, evenly in time."""
    each = max(LEAST_POSES, POSES // len(recordings))
    rows = [
        np.unique(np.linspace(0, len(recording.time) - 1, each).astype(int))
        for recording in recordings
    ]
    counts = [len(part) for part in rows]

    def repeated(values) -> np.ndarray:
        return np.repeat(np.array(values), counts, axis=0)

    at = [(r, part) for r, part in zip(recordings, rows, strict=True)]
    followed = [name for name in FOLLOWED if all(r.has(name) for r in recordings)]
    return Loops(
        [r.name for r, part in at for _ in part],
        repeated([r.kp for r in recordings]),
        repeated([r.kd for r in recordings]),
        np.concatenate([np.where(np.isnan(r.q), r.q_des, r.q)[part] for r, part in at]),
        repeated([r.control_rate_hz for r in recordings]),
        repeated([r.duration_s * r.control_rate_hz for r in recordings]),
        {name: np.concatenate([r.held(name)[part] for r, part in at]) for name in followed},
    )


def of_loops(model: Model, joints: tuple[str, ...], loops: Loops) -> Chatter | None:
    """As `chattering`, of any loops of `joints`."""
    found = plants(model, joints, loops)
    if found is None:
        return None
    mass, damping, stiffness, kp, kd = found
    period = 1 / loops.rate_hz

    def grown(more: np.ndarray) -> np.ndarray:
        """(k,) factors by which disturbances grow, as logarithms, with more armature (njoint,)."""
        step = transition(mass + np.diag(more), damping, stiffness, kp, kd, period)
        with np.errstate(divide="ignore"):
            return loops.ticks * np.log(chatter(step))

    nominal = grown(np.zeros(len(joints)))
    if nominal.max() <= np.log(GROWN):
        return None
    worst = int(np.argmax(nominal))
    number, joint = damping_number(mass[worst], kd[worst], period[worst])
    inertia = kd[worst, joint] * period[worst] / number if number > 0 else 0.0
    if number < 2:
        number, joint = stiffness_number(mass[worst], kp[worst], period[worst])
        inertia = kp[worst, joint] * period[worst] ** 2 / number
    # alone, a joint needs Kd h + Kp h²/2 < 2 M, whatever it carries
    enough = (period[:, None] * (kd + period[:, None] * kp / 2) / 2).max(axis=0)
    return Chatter(
        loops.names[worst], joints[joint], float(kp[worst, joint]), float(kd[worst, joint]),
        float(loops.rate_hz[worst]), float(inertia),
        _armature(model, joints, lambda more: grown(more).max() <= 0, enough),
    )  # fmt: skip


def plants(
    model: Model, joints: tuple[str, ...], loops: Loops
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray] | None:
    """Mass, damping, stiffness, Kp and Kd of each loop with the model's effects.

    As `t2l.sim.sampled_loop.transition` takes them; None where effects change the loop itself, as
    a filter does.
    """
    layout, u = model.vector(joints)
    extending = [term for term in layout.terms if term.effect.extends]
    compiled = with_effects(model.robot, joints, extending)
    if compiled.nv > len(joints):
        return None
    schedule = _schedule(loops)
    loop = made_loop(compiled, joints, schedule, 1, [(layout, u[None])], 1)
    if loop.controller_filters or loop.motor_filters or loop.sensor_filters:
        return None
    found = []
    for i, q in enumerate(loop.start_q - loop.encoder_offset):
        own = loop.batch.get_model(i)
        data = mujoco.MjData(own)
        data.qpos[loop.qpos] = q
        mujoco.mj_forward(own, data)
        mass = np.zeros((own.nv, own.nv))
        mujoco.mj_fullM(own, data, mass)
        found.append(
            (
                mass[np.ix_(loop.dofs, loop.dofs)],
                own.dof_damping[loop.dofs],
                own.jnt_stiffness[loop.ids],
            )
        )
    return *map(np.array, zip(*found, strict=True)), loop.kp, loop.kd


def _schedule(loops: Loops) -> Schedule:
    """Two ticks, as effects are installed into; the periods are seen to elsewhere."""
    k = len(loops.q)
    return Schedule(
        period_s=float(1 / loops.rate_hz.max()),
        commands=np.stack([loops.q] * 2),
        kp=loops.kp, kd=loops.kd, start_q=loops.q, start_dq=np.zeros_like(loops.q),
        compensated=np.zeros(k, bool), balanced=np.zeros(k, bool), sample_ticks=np.array([0, 1]),
        clock_s=np.zeros(k), logged={n: np.stack([v] * 2) for n, v in loops.logged.items()},
    )  # fmt: skip


def _armature(
    model: Model, joints: Sequence[str], settles: Callable[[np.ndarray], bool], enough: np.ndarray
) -> dict[str, float]:
    """By joint, what armature the model must have in all.

    Args:
        settles: whether every loop does with more of it, (njoint,) kg·m².
        enough: more than that no joint needs.
    """
    least = enough.copy()
    # those of little damping give up what they do not need first
    for joint in np.argsort(enough, kind="stable"):
        low, high = 0.0, enough[joint]
        least[joint] = 0.0
        if settles(least):
            continue
        for _ in range(HALVINGS):
            least[joint] = (low + high) / 2
            low, high = (low, least[joint]) if settles(least) else (least[joint], high)
        least[joint] = high
    known = model.effects.get("armature", {}).get("inertia", {})
    # a file that lacks it for one joint lacks it for all, and what the model has is fitted
    some = least[least > 0].min(initial=np.inf)
    return {
        name: _rounded_up(known.get(name, 0.0) + more)
        if more > 0
        else known.get(name, _rounded_up(some))
        for name, more in zip(joints, least, strict=True)
    }


def _rounded_up(value: float, digits: int = 2) -> float:
    if value <= 0:
        return 0.0
    unit = 10.0 ** (np.floor(np.log10(value)) - digits + 1)
    return float(f"{np.ceil(value / unit) * unit:.{digits}g}")
