"""A controller that damps by a velocity it has smoothed."""

import numpy as np

from t2l.effects.effect import Effect, Parameter


class VelocityFilter(Effect):
    """ẋ = ω (q̇ − x), and the controller's damping is −Kd x."""

    name = "velocity_filter"
    title = "velocity low-pass"
    parameters = (
        Parameter(
            "cutoff", "Hz", 0.5, 500.0, "corner frequency", neutral=np.inf, log=True,
            per_joint=False,
        ),
    )  # fmt: skip
    summary = "the controller smooths the velocity that it measures before it damps by it"
    signature = "fast motion is less damped than the gains say, most where Kd is large"
    source = "first-order low-pass, exact for a held velocity"
    follows = "acceleration"
    order = -5

    def export(self, to, joints, values):
        to.cannot_carry(self.name, "MuJoCo's actuators have no filter on the velocity")

    def install(self, loop, rows, joints, values):
        keep = np.exp(-2 * np.pi * values["cutoff"] * loop.period_s)
        state, at = {}, (rows, loop.columns(joints))

        def measured(tick, q, dq):
            state["dq"] = dq  # other effects may still change it

        def change(tick, torque):
            velocity = state["dq"][at]
            smooth = velocity + (state.get("smooth", velocity) - velocity) * keep
            state["smooth"] = smooth
            torque[at] += loop.kd[at] * (velocity - smooth)

        loop.sensor_filters.append(measured)
        loop.controller_filters.append(change)

    def starts(self, scales):
        return [{"cutoff": np.array([f])} for f in (3.0, 10.0, 30.0, 100.0)]
