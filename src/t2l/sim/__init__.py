"""The simulator loop: many simulations of one model, each with its own gains."""

from t2l.sim.batch import (
    apply_position_gains,
    apply_torque_control,
    diverged,
    make_batch,
    step,
)

__all__ = ["apply_position_gains", "apply_torque_control", "diverged", "make_batch", "step"]
