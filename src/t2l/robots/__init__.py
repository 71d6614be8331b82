"""Robots: their MJCF as a spec to build a scene around, and their limits."""

from t2l.robots.robot import Robot

__all__ = ["Robot"]
