"""Robots at the other end: back ends, recorders, and the guard that commands pass."""
