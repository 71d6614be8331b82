"""Position commands that arrive late."""

import numpy as np

from t2l.effects.effect import Effect, Parameter


class CommandDelay(Effect):
    """q_des(t) → q_des(t − d)."""

    name = "command_delay"
    title = "command delay"
    parameters = (
        Parameter("delay", "s", 0.0, 0.3, "time from command to controller", per_joint=False),
    )
    summary = "position commands reach the controller late: network, bus, interpolation"
    signature = "the response is the model's shifted in time, alike at all gains"
    source = "q_des(t − d), interpolated between two ticks of the loop"
    follows = "command velocity"

    def install(self, loop, rows, joints, values):
        ticks = values["delay"] / loop.period_s
        whole = np.floor(ticks + 1e-9).astype(int)
        rest = ticks - whole
        recording = np.arange(loop.batch.nsim)[rows, None] % loop.nrec
        commands = loop.schedule.commands

        at = rows, loop.columns(joints)

        def change(tick, target):
            late = np.maximum(tick - whole, 0)
            later = np.maximum(tick - whole - 1, 0)
            newer, older = commands[late, recording, joints], commands[later, recording, joints]
            target[at] = newer + rest * (older - newer)

        loop.command_filters.append(change)

    def starts(self, scales):
        return [{"delay": np.array([d])} for d in (0.002, 0.005, 0.01, 0.02, 0.04, 0.08)]
