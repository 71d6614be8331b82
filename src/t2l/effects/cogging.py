"""Torque ripple over the angle of the motor."""

import numpy as np

from t2l.effects.effect import Effect, Parameter
from t2l.sim.loop import over_ticks

FEWEST, MOST = 3.0, 500.0  # bound: periods in a turn
# numerics: rad by which the ends of the motion shift between periods that are tried
PHASE_STEP = 0.5
LEAST_RANGE_RAD = 0.05  # numerics: of a motion, for that
TOO_ALIKE = 1e-6  # numerics: singular values of the parts of a ripple, below which one does nothing


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
        at = ..., rows, loop.columns(joints)

        @over_ticks
        def add(tick, q, dq, torque):
            angle = values["periods"] * q[at] + values["phase"]
            torque[at] += values["amplitude"] * np.sin(angle)

        loop.joint_torques.append(add)

    def starts(self, scales):
        one = np.ones_like(scales.torque)
        return [{"amplitude": 0.01 * scales.torque, "phase": 0.0 * one, "periods": 10.0 * one}]

    def read_off(self, q, torque, clock_s):
        periods, (sine, cosine) = strongest_ripple(q, torque, np.ones_like(q))
        return {
            "amplitude": np.hypot(sine, cosine),
            "phase": np.arctan2(cosine, sine),
            "periods": periods,
        }


def strongest_ripple(
    q: np.ndarray, torque: np.ndarray, motor: np.ndarray
) -> tuple[float, np.ndarray]:
    """Periods in a turn of the ripple that leaves least of a torque, and its two amplitudes.

    It is a sine and a cosine of so many periods of the positions q (n,) times `motor` (n,), fitted
    to the torque (n,) beside a multiple of that and a constant.
    """
    step = PHASE_STEP / max(np.ptp(q), LEAST_RANGE_RAD)
    grid = np.arange(FEWEST, MOST, step)
    # sines of ever more periods are turned from one to the next
    wave, turn = motor * np.exp(1j * FEWEST * q), np.exp(1j * step * q)
    rows = np.stack([motor, motor, motor, np.ones_like(q), torque])
    products = np.empty((len(grid), len(rows), len(rows)))
    for product in products:
        rows[0], rows[1] = wave.imag, wave.real
        np.matmul(rows, rows.T, out=product)
        wave *= turn
    normal, target = products[:, :-1, :-1], products[:, :-1, -1:]
    weights = np.linalg.pinv(normal, rcond=TOO_ALIKE**2, hermitian=True) @ target
    periods = grid[np.argmax((weights * target).sum(axis=(1, 2)))]
    angle = periods * q
    parts = np.stack([motor * np.sin(angle), motor * np.cos(angle), *rows[2:-1]], axis=1)
    return periods, np.linalg.lstsq(parts, torque, rcond=TOO_ALIKE)[0][:2]


def ripple_over_angle(robot, joints, values):
    """Add A sin(N q + φ)."""
    angle = values["periods"] * robot.angle[joints] + values["phase"]
    robot.torque[joints] += values["amplitude"] * np.sin(angle)
