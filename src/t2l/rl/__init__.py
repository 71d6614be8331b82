"""Reaching by reinforcement learning in an identified simulator."""
