"""A formula as an effect file, the kind that a user writes: see docs/extending.md."""

import re

from t2l.effects.exported import JOINT
from t2l.effects.exported import MOTOR as MOTOR_SIGNAL
from t2l.effects.law import FRICTION, LIMIT, MOTOR, PHASE, TENDON, TORQUE, Law
from t2l.effects.learned import order
from t2l.propose.expression import Formula
from t2l.propose.wording import named

BOUND = 10.0  # bound: times a constant: as far as later fits may move it

TEXT = '''"""{title}, learned from recordings by t2l propose.

    {sentence}
    x: {variable}

Edit it as you like: name, formula, constants and bounds are yours.
"""

import numpy as np

from t2l.effects import Effect, Parameter
{imports}from t2l.effects.law import Law
from t2l.effects.{uses}

LAW = Law({kind!r}, {joint!r}, {follows!r}, {of!r})
{lever}

def law(x, {arguments}):
    """{what}."""
    return {text} + 0 * x


class {cls}(Effect):
    """{symbol} = {text}."""

    name = {name!r}
    title = {title!r}
    parameters = (
{parameters}
    )
    summary = {summary!r}
    signature = {signature!r}
    source = "t2l propose, from recordings"
    follows = {condition!r}
{when}
    def install(self, loop, rows, joints, values):
{install}

    def starts(self, scales):
        one = {one}
        return [{{{starts}}}]
{export}'''

# of the lever arms of a tendon
LEVER = "RATIO = {ratio:.6g}  # the lever arm at {of} over that at {joint}\n"

VALUE = """        value = variable(loop, rows, LAW, self.name)
"""

INSTALL_TORQUE = f"""{VALUE}{{motor}}
        def add(tick, q, dq, torque):
            x = value(tick, q, dq, {{held}})[:, None]
            torque[rows, joints] += law(x, **values)

        loop.joint_torques.append(add)"""

NOT_EXPORTED = """
    def export(self, to, joints, values):
        to.cannot_carry(self.name, "a simulator has no {follows}")
"""

EXPORT = '''
    def export(self, to, joints, values):
{room}        own = {{**values, "of": to.joints.index(LAW.of)}}
        to.call(self.name, {push}, joints, own, {on!r})


def {push}(robot, joints, values):
    """What the exported robot adds before each timestep."""
    x = {x}
    {arguments}, of = (values[name] for name in {names})
    robot.{signal}[joints] += {text}
'''

EXPORT_LIMIT = '''
    def export(self, to, joints, values):
        to.call(self.name, {push}, joints, values, {on!r})


def {push}(robot, joints, values):
    """What the exported robot's motors can give."""
    [{arguments}] = (values[name] for name in {names})
    dq = robot.dq[joints]
    most, least = ({text} + 0 * x for x in (dq, -dq))
    robot.motor[joints] = np.clip(robot.motor[joints], -least, most)
'''

EXPORT_TENDON = '''
    def export(self, to, joints, values):
        both = {{"joint": to.joints.index(LAW.joint), "of": to.joints.index(LAW.of)}}
        to.call(self.name, {push}, joints, {{**values, **both}}, {on!r})


def {push}(robot, joints, values):
    """What the exported robot adds to both joints before each timestep."""
    {arguments}, joint, of = (values[name] for name in {names})
    x = robot.{signal}[[joint]] + RATIO * robot.{signal}[[of]]
    tension = {text}
    robot.torque[[joint]] += tension
    robot.torque[[of]] += RATIO * tension
'''

# the MJCF's own friction stays beside what is added
ROOM = "        export_friction(to, joints, np.zeros(len(joints)))\n"
ROOM_IMPORT = "from t2l.effects.coulomb_friction import export_friction\n"

# what an exported robot calls the variables
EXPORTED = {
    "constant": "0.0",
    "position": 'robot.angle[values["of"]]',
    "velocity": 'robot.velocity[values["of"]]',
    "speed": 'abs(robot.velocity[values["of"]])',
    "commanded torque": 'robot.motor[values["of"]]',
    "commanded torque size": 'abs(robot.motor[values["of"]])',
    "load": 'robot.load[values["of"]]',
    "time": "robot.data.time + 0.5 * robot.period_s",
    # a formula goes on beyond a period
    "phase": "robot.data.time + 0.5 * robot.period_s",
}

INSTALL_FRICTION = f"""{VALUE}        qpos = loop.batch.qpos

        def add(tick, dq, motor, level):
            x = value(tick, qpos[:, loop.qpos], dq, motor[rows])[:, None]
            level[rows, joints] += law(x, **values)

        loop.friction.append(add)"""

INSTALL_MOTOR = f"""{VALUE}
        def change(tick, torque):
            x = value(tick, None, None, None)[:, None]
            torque[rows, joints] *= np.maximum(1 + law(x, **values), 0.0)

        loop.motor_filters.append(change)"""

INSTALL_LIMIT = (
    """        limit_by_velocity(loop, rows, joints, lambda tick, x: law(x, **values))"""
)

INSTALL_TENDON = (
    """        pull(loop, rows, LAW, RATIO, lambda x: law(x[:, None], **values)[:, 0])"""
)

# by kind: symbol, what it is, and how it is installed
KINDS = {
    TORQUE: ("τ", "the torque, N·m", INSTALL_TORQUE),
    FRICTION: ("F", "the level of dry friction, N·m", INSTALL_FRICTION),
    MOTOR: ("Δτ/τ", "the change of the motor torque, as a share of it", INSTALL_MOTOR),
    LIMIT: ("τ", "the most that the motor gives, N·m", INSTALL_LIMIT),
    TENDON: ("τ", "the torque on the first joint, N·m", INSTALL_TENDON),
}

CONDITIONS = {
    "position": "position",
    "velocity": "velocity",
    "speed": "direction",
    "constant": "constant",
    "commanded torque": "torque",
    "commanded torque size": "load",
    "load": "gravity",
    "time": "time",
    "phase": "time",
}


def effect_name(law: Law) -> str:
    """What users type: a law's name as a plain one."""
    return re.sub(r"[^A-Za-z0-9_]", "_", law.name.replace("learned_", "formula_", 1))


def effect_text(law: Law, formula: Formula, ratio: float = 0.0) -> str:
    """The text of a Python file with the effect; `ratio` of a tendon, as of its curve."""
    title = named(law).removeprefix("a ")
    dry = law.kind == FRICTION
    commanded = law.follows == "commanded torque"
    motor = "        held = demanded(loop, rows)\n" if commanded else ""
    uses = "learned import demanded, variable" if commanded else "learned import variable"
    push, names = EXPORT, (*formula.values, "of")
    if law.kind == LIMIT:
        push, names = EXPORT_LIMIT, (*formula.values,)
        uses = "torque_speed_limit import limit_by_velocity"
    signal, lever = "friction" if dry else "torque", ""
    if law.kind == TENDON:
        push, names = EXPORT_TENDON, (*formula.values, "joint", "of")
        signal, lever = "angle" if law.follows == "position" else "velocity", LEVER
        uses = "learned import pull"
    symbol, what, install = KINDS[law.kind]
    # a formula of what repeats goes on with the clock
    followed = "log's clock" if law.follows == PHASE else f"{law.follows} of {law.of}"
    if law.kind == TENDON:
        followed = f"{law.follows} of {law.joint} + RATIO times that of {law.of}"
    export = NOT_EXPORTED.format(follows=law.follows)
    if law.follows in EXPORTED:
        export = push.format(
            x=EXPORTED[law.follows], arguments=", ".join(formula.values), text=formula.text,
            names=names, signal=signal,
            room=ROOM if dry else "", push=f"push_{effect_name(law)}",
            on=MOTOR_SIGNAL if commanded or law.kind == LIMIT else JOINT,
        )  # fmt: skip
    return TEXT.format(
        title=title, uses=uses, imports=ROOM_IMPORT if ROOM in export else "",
        sentence=f"{symbol} = {formula.sentence(4)}",
        variable=followed + (f", {law.unit}" if law.unit else ""),
        kind=law.kind, joint=law.joint, follows=law.follows, of=law.of,
        lever=lever.format(joint=law.joint, of=law.of, ratio=ratio),
        arguments=", ".join(formula.values), text=formula.text,
        what=what,
        cls="".join(part[:1].upper() + part[1:] for part in effect_name(law).split("_")),
        symbol=symbol,
        name=effect_name(law),
        parameters="\n".join(
            _parameter(law, n, v, formula.units[n]) for n, v in formula.values.items()
        ),
        summary=named(law),
        signature=f"the error follows the {followed}",
        when="".join(
            f"    {name} = {value!r}\n"
            for name, value in (
                ("needs", law.needs), ("order", order(law)),
                ("coupled", law.kind == TENDON), ("least_joints", 2 * (law.kind == TENDON)),
            )
            if value
        ),
        condition=CONDITIONS.get(law.follows, "") if law.of == law.joint else "",
        install=install.format(motor=motor, held="held[0]" if commanded else "None"),
        export=export,
        one="np.ones(1)" if law.kind == TENDON else "np.ones_like(scales.torque)",
        starts=", ".join(f'"{name}": {value:.6g} * one' for name, value in formula.values.items()),
    )  # fmt: skip


def _parameter(law: Law, name: str, value: float, unit: str) -> str:
    reach = BOUND * abs(value) + 1e-6
    # a torque of zero is none, and a limit of zero is not
    is_torque = law.kind != LIMIT and (unit == "N·m" or unit.startswith("N·m/"))
    neutral = "" if is_torque else ", neutral=np.nan"
    # a tendon is one for two joints
    whole = ", per_joint=False" if law.kind == TENDON else ""
    return (
        f'        Parameter("{name}", "{unit}", {-reach:.4g}, {reach:.4g}, "{name} of the formula"'
        f"{neutral}{whole}, size={0.1 * abs(value) + 1e-9:.3g}),"
    )
