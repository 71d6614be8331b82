"""A torque that was learned from recordings: a law of one variable, as a tabulated curve.

Six kinds of law, each of one variable x:

    torque       τ = f(x)
    friction     |τ| ≤ f(x), against the motion; it holds the joint at rest
    motor        τ = max(1 + f(x), 0) τ_motor, of a variable that does not depend on the motion
    inertia      τ = −I q̈, a straight line over the acceleration
    limit        −f(−q̇) ≤ τ_motor ≤ f(q̇)
    tendon       τ = f(x_i + r x_j) on joint i, and r f on joint j, which no energy comes from
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from t2l.effects.armature import LIGHTEST, add_armature
from t2l.effects.coulomb_friction import export_friction
from t2l.effects.effect import Effect, Values
from t2l.effects.exported import JOINT, Exported
from t2l.effects.exported import MOTOR as MOTOR_SIGNAL
from t2l.effects.law import (
    FRICTION,
    INERTIA,
    LIMIT,
    MOTOR,
    OTHERS,
    PHASE,
    SESSION,
    TENDON,
    TORQUE,
    Curve,
    Law,
)
from t2l.effects.learned_callbacks import (
    learned_law,
    learned_limit,
    learned_tendon,
)
from t2l.effects.torque_constant import TorqueConstant
from t2l.effects.torque_speed_limit import TorqueSpeedLimit, limit_by_velocity
from t2l.sim.servo import ServoLoop


class Lawful(Effect):
    """An effect that is a law: it says what acts at a value of the law's variable."""

    law: Law

    def __init__(self, law: Law):
        self.law = law
        self.needs, self.order = law.needs, order(law)

    def places(self, joints):
        return (tuple(joints).index(self.law.joint),)

    def carried(self, to: Exported, values: Values) -> dict[str, Any]:
        """What `learned_value` of an exported robot needs, and the `ratio` of a tendon."""
        raise NotImplementedError

    def export(self, to, joints, values):
        law = self.law
        if law.given:
            to.cannot_carry(self.name, f"a simulator has no {law.follows}")
            return
        own = self.carried(to, values)
        if law.kind == LIMIT:
            to.call(self.name, learned_limit, joints, own, MOTOR_SIGNAL)
            return
        own |= {"follows": law.follows, "of": to.joints.index(law.of)}
        if law.kind == TENDON:
            own["joint"] = to.joints.index(law.joint)
            to.call(self.name, learned_tendon, joints, own)
            return
        if law.kind == FRICTION:
            # the MJCF's own friction stays beside what is added
            export_friction(to, joints, np.zeros(len(joints)))
        demanded_here = law.kind == TORQUE and law.follows == "commanded torque"
        on = MOTOR_SIGNAL if demanded_here else JOINT
        to.call(self.name, learned_law, joints, own | {"kind": law.kind}, on)


class LearnedTorque(Lawful):
    """A tabulated law; it has no parameters to fit."""

    title = "learned torque"
    parameters = ()
    summary = "a torque that was learned from recordings"
    signature = "the error follows what the curve follows"
    source = "the recordings that it was learned from"

    def __init__(self, curve: Curve):
        super().__init__(curve.law)
        self.curve, self.name = curve, curve.law.name

    def starts(self, scales):
        return [{}]

    def install(self, loop, rows, joints, values):
        count = rows.stop - rows.start
        law, curve = self.law, self.curve
        if law.kind == INERTIA:
            add_armature(loop, rows, joints, np.full((count, 1), curve.inertia), LIGHTEST)
            return
        grid, torque = curve.table()
        looked_up(loop, rows, law, grid, np.tile(torque, (count, 1)), ratio=curve.ratio)

    def export(self, to, joints, values):
        curve = self.curve
        if self.law.kind == INERTIA:
            for joint in to.each(joints):
                joint.armature += curve.inertia
            return
        super().export(to, joints, values)

    def carried(self, to, values):
        grid, torque = self.curve.table()
        return {"at": grid, "torque": torque, "ratio": self.curve.ratio}


def order(law: Law) -> int:
    """When a law applies among effects on the same signal, as `Effect.order`."""
    same = {MOTOR: TorqueConstant, LIMIT: TorqueSpeedLimit}
    return same.get(law.kind, LearnedTorque).order


def looked_up(
    loop: ServoLoop,
    rows: slice,
    law: Law,
    grid: np.ndarray,
    tables: np.ndarray,
    stretch: np.ndarray | float = 0.0,
    ratio: np.ndarray | float = 0.0,
) -> None:
    """Add a law whose torque is looked up in tables (nrow, g) over an equally spaced grid (g,).

    Args:
        stretch: (nrow,) of the period of a phase, as a share of the grid's length.
        ratio: (nrow,) of a tendon, as of `Curve`.
    """
    length = reach_of(grid, stretch)
    flat, first, find = tables.ravel(), np.arange(len(tables)) * len(grid), places(grid, length)

    def look_up(x) -> np.ndarray:
        below, part = find(x)
        below += first
        left = flat.take(below)
        below += 1
        return left + part * (flat.take(below) - left)

    acting(loop, rows, law, look_up, ratio, turn=(grid[0], length))


def reach_of(grid: np.ndarray, stretch: np.ndarray | float) -> np.ndarray | float:
    """How long an equally spaced grid (g,) is that is stretched by a share of its length."""
    return max(grid[-1] - grid[0], 1e-12) * (1 + stretch)


def places(grid: np.ndarray, length: np.ndarray | float) -> Callable:
    """Where values x (n,) lie on an equally spaced grid (g,): the point below, the part beyond it.

    Args:
        length: of the grid, which may be (n,).
    """
    per_step, last = (len(grid) - 1) / length, len(grid) - 1 - 1e-9

    def find(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        # this runs at every tick; a simulation that diverged is NaN, which fmax passes over
        place = np.fmin(np.fmax((x - grid[0]) * per_step, 0.0), last)
        below = place.astype(np.intp)
        place -= below
        return below, place

    return find


def acting(
    loop: ServoLoop,
    rows: slice,
    law: Law,
    says: Callable[[np.ndarray], np.ndarray],
    ratio: np.ndarray | float = 0.0,
    turn: tuple[float, np.ndarray | float] = (0.0, np.inf),
) -> None:
    """Add a law that says (nrow,) of its variable (nrow,).

    Args:
        ratio: (nrow,) of a tendon, as of `Curve`.
        turn: of a phase, as of `variable`.
    """
    joint = loop.joints.index(law.joint)
    if law.kind == LIMIT:
        limit_by_velocity(loop, rows, np.array([joint]), lambda tick, x: says(x[..., 0])[..., None])
        return
    if law.kind == TENDON:
        pull(loop, rows, law, ratio, says)
        return
    value = variable(loop, rows, law, turn=turn)

    def at(tick, q, dq, motor) -> np.ndarray:
        return says(value(tick, q, dq, motor))

    if law.kind == MOTOR:

        def change(tick, torque):
            torque[rows, joint] *= np.maximum(1 + at(tick, None, None, None), 0.0)

        loop.motor_filters.append(change)
        return
    if law.kind == FRICTION:
        qpos, needs_q = loop.batch.qpos, law.follows in OTHERS

        def add_friction(tick, dq, motor, level):
            q = qpos[:, loop.qpos] if needs_q else None
            level[rows, joint] += at(tick, q, dq, motor[rows])

        loop.friction.append(add_friction)
        return
    motor = demanded(loop, rows) if law.follows == "commanded torque" else None

    def add(tick, q, dq, torque):
        torque[rows, joint] += at(tick, q, dq, None if motor is None else motor[0])

    loop.joint_torques.append(add)


def pull(
    loop: ServoLoop,
    rows: slice,
    law: Law,
    ratio: np.ndarray | float,
    force: Callable[[np.ndarray], np.ndarray],
) -> None:
    """Add a tendon: `force`, of x_i + r x_j (nrow,), on joint i, and r times that on joint j."""
    joint, other = loop.joints.index(law.joint), loop.joints.index(law.of)
    here, there = variable(loop, rows, replace(law, of=law.joint)), variable(loop, rows, law)

    def add(tick, q, dq, torque):
        tension = force(here(tick, q, dq, None) + ratio * there(tick, q, dq, None))
        torque[rows, joint] += tension
        torque[rows, other] += ratio * tension

    loop.joint_torques.append(add)


def variable(
    loop: ServoLoop,
    rows: slice,
    law: Law,
    turn: tuple[float, np.ndarray | float] = (0.0, np.inf),
) -> Callable:
    """The variable (nrow,) of a law, called with (tick, q, dq, motor torque of the rows).

    Args:
        turn: where a phase begins, and the period after which it does so anew, which may be
            (nrow,); by default never, so that it is the clock.

    Raises:
        EffectError: when called, of a column that the recordings lack.
    """
    of = loop.joints.index(law.of)
    if law.column:
        return lambda tick, q, dq, motor: loop.logged(law.column, tick, law.name)[rows, of]
    if law.follows == SESSION:
        return lambda tick, q, dq, motor: loop.clock_s(tick)[rows, 0]
    if law.follows == PHASE:
        begin, period = turn
        return lambda tick, q, dq, motor: begin + (loop.clock_s(tick)[rows, 0] - begin) % period
    if law.follows == "load":
        bias, dof = loop.batch.bind("qfrc_bias"), loop.dofs[of]
        return lambda tick, q, dq, motor: bias[rows, dof]
    return {
        "constant": lambda tick, q, dq, motor: np.zeros(rows.stop - rows.start),
        "position": lambda tick, q, dq, motor: q[rows, of],
        "velocity": lambda tick, q, dq, motor: dq[rows, of],
        "speed": lambda tick, q, dq, motor: np.abs(dq[rows, of]),
        "commanded torque": lambda tick, q, dq, motor: motor[:, of],
        "commanded torque size": lambda tick, q, dq, motor: np.abs(motor[:, of]),
        "time": lambda tick, q, dq, motor: loop.elapsed_s(tick)[rows, 0],
    }[law.follows]


def demanded(loop: ServoLoop, rows: slice) -> list[np.ndarray]:
    """A place that holds what the controller demands at the present tick, (nrow, njoint)."""
    held = [np.zeros((rows.stop - rows.start, len(loop.joints)))]

    def keep(tick, torque):
        held[0] = torque[rows].copy()

    loop.motor_filters.append(keep)
    return held
