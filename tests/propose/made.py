"""Recordings of machines with a torque that their models lack, and what is learned of them."""

import numpy as np

from t2l.detective.data_split import split
from t2l.detective.explanation import proposed
from t2l.effects.law import Curve
from t2l.identify.model import Model
from tests.diagnose.made import measured, recording, swing

POSITIONS = np.linspace(-2.0, 2.5, 80)


def planted(law, at, torque):
    return Curve(law, tuple(at.tolist()), tuple(torque.tolist()))


def machine(robot, curves, count=2, noise_rad=1e-4, commands=swing, seed=0):
    """Recordings of a robot with curves that its model lacks."""
    model = Model(robot, learned=tuple(curves))
    gains = ((5.0, 0.3, 0.7), (30.0, 1.0, 1.1), (12.0, 0.5, 0.9))[:count]
    made = [
        recording(robot, commands(0.5, hz), f"kp{kp:g}", kp, kd, 1.5, control_rate_hz=500.0)
        for kp, kd, hz in gains
    ]
    return [measured(r, None, noise_rad, seed + i, model) for i, r in enumerate(made)]


def sway(amplitude, hz):
    return lambda t: 0.2 + amplitude * np.sin(2 * np.pi * 0.8 * hz * t)


def learn(robot, recordings, report=()):
    """What `t2l propose` finds."""
    return proposed(Model(robot), split(robot, recordings, report, threads=1))
