"""The motions that a robot is identified from: the study's sine, and one that shows more."""

import numpy as np

from t2l.gains import Cell
from t2l.hardware.excitation import envelope, multisine, study_sine
from t2l.hardware.features import Features
from t2l.hardware.limits import (
    POSITION_MARGIN_RAD,
    position_bounds,
    torque_bounds,
    velocity_bounds,
)
from t2l.hardware.motion import COMMAND_RATE_HZ, Motion
from t2l.hardware.nominal import respond
from t2l.robots import Robot

# of what breaks a joint loose: below it, a motion shows little but friction
PEAK_OVER_BREAKAWAY = 3.0
# whole cycles that the lowest frequency makes
LEAST_CYCLES = 2
RAMP_S = 0.5
# of velocity and torque limits: the model that predicts is the one that is to be corrected
SAFE = 0.8
SMALLER = 0.9
_PARTS = SMALLER ** np.arange(30)
_LOOP_HZ = 1000
_SEED = 20


def identification_motion(
    robot: Robot,
    cell: Cell,
    amplitude_rad: float,
    duration_s: float,
    excitation: str = "sine",
    highest_hz: float = 5.0,
    breakaway_nm: float = 1.5,
) -> Motion:
    """Commands about home on all joints, at 50 Hz.

    Args:
        amplitude_rad: of the sine; of the multisine at least.
        excitation: `sine`, the study's of 0.5 Hz, or `multisine`, of frequencies up to
            `highest_hz`. A multisine is made so large that a joint that it does not move feels
            three times `breakaway_nm`, and then as small as the robot's limits ask.
        breakaway_nm: torque that breaks the joints loose.
    """
    gains = [np.full(len(robot.joints), float(gain)) for gain in (cell.kp, cell.kd)]
    ncommand = round(duration_s * COMMAND_RATE_HZ)
    if excitation == "sine":
        q_des = robot.home + study_sine(ncommand, amplitude_rad)
    else:
        amplitude = max(amplitude_rad, PEAK_OVER_BREAKAWAY * breakaway_nm / cell.kp)
        offsets = amplitude * _multisine(len(robot.joints), ncommand, highest_hz)
        q_des = robot.home + _within_limits(robot, offsets, *gains)
    return Motion(cell.name, q_des, COMMAND_RATE_HZ, *gains)


def _multisine(njoint: int, ncommand: int, highest_hz: float) -> np.ndarray:
    """(ncommand, njoint) with a largest offset of 1 each, from rest to rest."""
    time = np.arange(ncommand) / COMMAND_RATE_HZ
    lowest = LEAST_CYCLES * COMMAND_RATE_HZ / ncommand
    frequencies = lowest * np.arange(1, max(1, int(highest_hz / lowest)) + 1)
    tones = multisine(time, np.ones(njoint), frequencies, _SEED)
    tones *= envelope(time, time[-1], RAMP_S)[:, None]
    return tones / np.abs(tones).max(axis=0)


def _within_limits(robot: Robot, offsets: np.ndarray, kp: np.ndarray, kd: np.ndarray) -> np.ndarray:
    """Offsets from home (ncommand, njoint) rad, where a joint that would break a limit moves less.

    Commands and the motion that the MJCF predicts keep off the ends of the ranges; velocities and
    torques stay below a part of their limits, underdamped swings included.
    """
    beyond = _beyond(robot, _PARTS[:, None, None] * offsets, kp, kd)
    # the first part, and so the largest, from which on none is beyond
    first = len(_PARTS) - np.argmax(beyond[::-1], axis=0)
    part = _PARTS[np.where(beyond.any(axis=0), np.minimum(first, len(_PARTS) - 1), 0)]
    # now that each moves by a part of its own, some are driven by others
    while _beyond(robot, (part * offsets)[None], kp, kd).any():
        part = SMALLER * part
    return part * offsets


def _beyond(robot: Robot, offsets: np.ndarray, kp: np.ndarray, kd: np.ndarray) -> np.ndarray:
    """Which joints a motion takes beyond a limit, (nmotion, njoint), of (nmotion, ncommand, njoint)
    offsets from home."""
    found = respond(robot, Features(_LOOP_HZ), robot.home + offsets, COMMAND_RATE_HZ, kp, kd)
    positions = position_bounds(robot, POSITION_MARGIN_RAD)
    beyond = np.zeros((len(offsets), len(robot.joints)), bool)
    for bounds, values in (
        (positions, found.q_des),
        (positions, found.q),
        (velocity_bounds(robot), found.dq / SAFE),
        (torque_bounds(robot), found.torque / SAFE),
    ):
        # what ran away is beyond everything
        beyond |= (bounds.outside(values) | np.isnan(values)).any(axis=1)
    return beyond
