"""What commands a motion takes under each pair of gains, and how well they lead the machine.

Torque-to-position retargeting (`t2l.demos.retarget`): q_des = q + (τ + Kd q̇) / Kp, the mean held
over a period of the policy. The replay follows these commands open loop, in the machine's own loop
with all effects of its model, in free motion.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from t2l.advise.shown import Shown
from t2l.errors import ConfigurationError
from t2l.identify.model import Model
from t2l.identify.prediction import with_effects
from t2l.identify.simulation import made_loop
from t2l.sim.controllers.joint_pd import pd_torque, position_command
from t2l.sim.schedule import Schedule

REPLAYED = 3  # numerics: motions, those that move most; a cell's error is their mean
LONGEST_S = 3.0  # numerics: of each, from its start


@dataclass(frozen=True)
class Labels:
    """What a policy has to tell under c pairs of gains, (c, n) each.

    Attributes:
        lead_rad: RMS of how far commands are from where the robot is.
        roughness_rad: RMS of how much a command differs from the mean of the two beside it.
        beyond: share of commands beyond the joint's range.
        fast: share of changes from command to command faster than the joint may move.
    """

    lead_rad: np.ndarray
    roughness_rad: np.ndarray
    beyond: np.ndarray
    fast: np.ndarray


@dataclass(frozen=True)
class Replayed:
    """How c pairs of gains follow the motions, (c, n) each; infinite where they run away.

    Attributes:
        rmse_rad: of positions.
        saturated: share of commands at whose arrival the loop asks for more torque than there is.
    """

    rmse_rad: np.ndarray
    saturated: np.ndarray


def held_steps(rate_hz: float, policy_rate_hz: float) -> int:
    """Rows that each command is held for.

    Raises:
        ConfigurationError: the policy is faster than what was recorded.
    """
    steps = round(rate_hz / policy_rate_hz)
    if steps < 1:
        raise ConfigurationError(
            f"--policy-rate: found {policy_rate_hz:g} Hz; allowed: up to {rate_hz:g} Hz, at which "
            "the demonstrations were recorded"
        )
    return steps


def commands(
    q: np.ndarray, dq: np.ndarray, torque: np.ndarray, kp: np.ndarray, kd: np.ndarray, steps: int
) -> np.ndarray:
    """Held commands (c, ceil(rows/steps), n) rad of one motion under gains (c, n).

    Args:
        q, dq, torque: (rows, n) rad, rad/s and N·m.
    """
    asked = position_command(q, dq, torque, kp[:, None], kd[:, None])
    starts = np.arange(0, len(q), steps)
    lengths = np.diff([*starts, len(q)])
    return np.add.reduceat(asked, starts, axis=1) / lengths[:, None]


def labels(
    shown: Shown,
    kp: np.ndarray,
    kd: np.ndarray,
    steps: int,
    ranges: np.ndarray,
    velocity_limit: np.ndarray,
) -> Labels:
    """Of gains (c, n), over all motions.

    Args:
        steps: rows of a command.
        ranges, velocity_limit: (n, 2) rad and (n,) rad/s, infinite where unknown.
    """
    squares, count = np.zeros((2, *kp.shape)), np.zeros(2)
    over, fast, total = np.zeros(kp.shape), np.zeros(kp.shape), 0
    period = steps / shown.rate_hz
    for q, dq, torque in zip(shown.q, shown.dq, shown.torque, strict=True):
        found = commands(q, dq, torque, kp, kd, steps)
        squares[0] += ((found - q[::steps]) ** 2).sum(axis=1)
        bend = found[:, 1:-1] - (found[:, 2:] + found[:, :-2]) / 2
        squares[1] += (bend**2).sum(axis=1)
        count += found.shape[1], bend.shape[1]
        over += ((found < ranges[:, 0]) | (found > ranges[:, 1])).sum(axis=1)
        fast += (np.abs(np.diff(found, axis=1)) > velocity_limit * period).sum(axis=1)
        total += found.shape[1]
    lead, rough = np.sqrt(squares / np.maximum(count, 1)[:, None, None])
    return Labels(lead, rough, over / total, fast / total)


def replayed(
    model: Model,
    joints: tuple[str, ...],
    motions: Sequence[tuple[np.ndarray, np.ndarray, np.ndarray]],
    rate_hz: float,
    kp: np.ndarray,
    kd: np.ndarray,
    policy_rate_hz: float,
    control_rate_hz: float,
    compensated: bool,
    limit: np.ndarray,
    factor: np.ndarray | float = 1.0,
    threads: int = 1,
    progress: Callable[[float], None] = lambda part: None,
) -> Replayed:
    """Every motion under gains (c, n), all side by side.

    Args:
        model: of the machine, with its effects.
        motions: q, dq and the torque of the free motion, (rows, n) each; see `moving_most`.
        rate_hz: of their rows.
        limit: (n,) N·m of torque.
        factor: (2, n) on Kp and Kd, by which the machine has other gains than it is told; commands
            are made for what it has.
    """
    steps = held_steps(rate_hz, policy_rate_hz)
    rows = min(len(q) for q, _, _ in motions) // steps * steps
    own = np.broadcast_to(factor, (2, kp.shape[1]))
    real = own[0] * kp, own[1] * kd
    held = np.stack(
        [commands(*(part[:rows] for part in motion), *real, steps) for motion in motions], axis=1
    )  # (c, motion, command, n)
    c, m, told, n = held.shape
    ticks = round(told * steps / rate_hz * control_rate_hz)
    at = np.minimum((np.arange(ticks + 1) / control_rate_hz * rate_hz / steps + 1e-9), told - 1)
    samples = np.round(np.arange(1, told) * steps / rate_hz * control_rate_hz).astype(int)
    every, none = np.ones(c * m, bool), np.zeros(c * m, bool)
    schedule = Schedule(
        period_s=1 / control_rate_hz,
        commands=held.reshape(c * m, told, n).swapaxes(0, 1)[at.astype(int)],
        kp=np.repeat(kp, m, axis=0), kd=np.repeat(kd, m, axis=0),
        start_q=np.tile([q[0] for q, _, _ in motions], (c, 1)),
        start_dq=np.tile([dq[0] for _, dq, _ in motions], (c, 1)),
        compensated=every if compensated else none, balanced=none, sample_ticks=samples,
        command_period_s=np.full(c * m, steps / rate_hz),
    )  # fmt: skip
    layout, u = model.vector(joints)
    extending = [term for term in layout.terms if term.effect.extends]
    compiled = with_effects(model.robot, joints, extending)
    loop = made_loop(compiled, joints, schedule, 1, [(layout, u[None])], threads)
    q, dq = (part[0].reshape(c, m, told - 1, n) for part in loop.run(progress))
    wanted = np.stack([motion[0][steps:rows:steps] for motion in motions])
    gone = ~np.isfinite(q).all(axis=(1, 2, 3))
    error = np.sqrt(np.mean((q - wanted) ** 2, axis=(1, 2)))
    asked = pd_torque(held[:, :, 1:], q, dq, *(gain[:, None, None] for gain in real))
    saturated = (np.abs(asked) > limit).mean(axis=(1, 2))
    error[gone], saturated[gone] = np.inf, 1.0
    return Replayed(error, saturated)


def moving_most(
    shown: Shown, free: Callable[[list[np.ndarray], list[np.ndarray]], list[np.ndarray]]
) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """The motions to replay: q, dq and torque (rows, n) of `REPLAYED`, up to `LONGEST_S` of each.

    Args:
        free: torques of motions, by positions and velocities; see `t2l.advise.shown.free_torques`.
    """
    rows = round(LONGEST_S * shown.rate_hz)
    travel = [np.abs(np.diff(q[:rows], axis=0)).sum() for q in shown.q]
    chosen = np.argsort(travel)[::-1][:REPLAYED]
    q, dq = ([values[i][:rows] for i in chosen] for values in (shown.q, shown.dq))
    return list(zip(q, dq, free(q, dq), strict=True))


def plant_of(model: Model, joints: tuple[str, ...]) -> mujoco.MjModel:
    """The nominal robot of a model, which torques are told for."""
    return with_effects(model.robot, joints)
