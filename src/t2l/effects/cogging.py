"""Torque ripple over the angle of the motor."""

from collections.abc import Callable

import numpy as np

from t2l.effects.effect import Effect, Parameter

FEWEST, MOST = 3.0, 500.0  # bound: periods in a turn
# numerics: rad by which the ends of the motion shift between periods that are tried
PHASE_STEP = 0.5
LEAST_RANGE_RAD = 0.05  # numerics: of a motion, for that


class Cogging(Effect):
    """τ = A sin(N q + φ)."""

    name = "cogging"
    title = "cogging"
    parameters = (
        Parameter("amplitude", "N·m", 0.0, 10.0, "largest torque, A", scale="torque"),
        Parameter(
            "phase", "rad", -30.0, 30.0, "angle of the ripple where q is zero, φ", neutral=np.nan
        ),
        Parameter(
            "periods", "1/rev", FEWEST, MOST, "periods in a turn of the joint, N", neutral=np.nan
        ),
    )
    summary = "torque that ripples with the joint angle, from magnets and gear teeth"
    signature = "the error repeats over the position, alike in both directions"
    source = "MuJoCo, DC motor technical note, section 1.2"
    remembers = False
    follows = "position"

    def export(self, to, joints, values):
        to.call(self.name, ripple_over_angle, joints, values)

    def install(self, loop, rows, joints, values):
        at = rows, loop.columns(joints)

        def add(tick, q, dq, torque):
            # the angle in the middle of the period for which the torque is held
            angle = values["periods"] * (q[at] + 0.5 * loop.period_s * dq[at])
            torque[at] += values["amplitude"] * np.sin(angle + values["phase"])

        loop.joint_torques.append(add)

    def starts(self, scales):
        one = np.ones_like(scales.torque)
        return [{"amplitude": 0.01 * scales.torque, "phase": 0.0 * one, "periods": 10.0 * one}]

    def read_off(self, q, torque, clock_s):
        periods, (sine, cosine) = strongest_ripple(q, lambda n: _ripple(q, torque, n))
        return {
            "amplitude": np.hypot(sine, cosine),
            "phase": np.arctan2(cosine, sine),
            "periods": periods,
        }


def strongest_ripple(
    q: np.ndarray, ripple: Callable[[float], tuple[float, np.ndarray]]
) -> tuple[float, np.ndarray]:
    """Periods in a turn of the ripple that leaves least along positions (n,), and its amplitudes.

    Args:
        ripple: of so many periods, what it leaves and its amplitudes of sine and cosine.
    """
    step = PHASE_STEP / max(np.ptp(q), LEAST_RANGE_RAD)
    grid = np.arange(FEWEST, MOST, step)
    periods = grid[np.argmin([ripple(n)[0] for n in grid])]
    return periods, ripple(periods)[1]


def _ripple(q: np.ndarray, torque: np.ndarray, periods: float) -> tuple[float, np.ndarray]:
    """What a ripple beside a constant leaves, and its two amplitudes."""
    parts = np.stack([np.sin(periods * q), np.cos(periods * q), np.ones_like(q)], axis=1)
    weights = np.linalg.lstsq(parts, torque, rcond=1e-6)[0]
    return float(np.mean((torque - parts @ weights) ** 2)), weights[:2]


def ripple_over_angle(robot, joints, values):
    """Add A sin(N q + φ)."""
    angle = values["periods"] * robot.angle[joints] + values["phase"]
    robot.torque[joints] += values["amplitude"] * np.sin(angle)
