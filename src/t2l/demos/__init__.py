"""Demonstrations: a torque-controlled expert, and its retargeting to position control."""
