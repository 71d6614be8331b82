"""What an exported robot runs before each timestep for a learned torque: a curve or a formula."""

import numpy as np


def learned_law(robot, joints, values):
    """Add a torque, or the level of dry friction."""
    of, clock_s = values["of"], robot.data.time + 0.5 * robot.period_s
    x = {
        "constant": 0.0,
        "position": robot.angle[of],
        "velocity": robot.rate[of],
        "speed": abs(robot.rate[of]),
        "commanded torque": robot.motor[of],
        "commanded torque size": abs(robot.motor[of]),
        "load": robot.load[of],
        "time": clock_s,
        "phase": folded(clock_s, values),
    }[values["follows"]]
    adds_to = robot.friction if values["kind"] == "friction" else robot.torque
    adds_to[joints] += learned_value(x, values)


def learned_tendon(robot, joints, values):
    """Pull at two joints."""
    joint, of, ratio = values["joint"], values["of"], values["ratio"]
    x = robot.angle if values["follows"] == "position" else robot.rate
    tension = learned_value(x[joint] + ratio * x[of], values)
    robot.torque[joint] += tension
    robot.torque[of] += ratio * tension


def learned_limit(robot, joints, values):
    """Cut what goes beyond a limit."""
    dq = robot.dq[joints]
    least, greatest = -learned_value(-dq, values), learned_value(dq, values)
    robot.motor[joints] = np.clip(robot.motor[joints], least, greatest)


def learned_value(x, values):
    """What a formula says, or what is looked up in a table."""
    if "formula" in values:
        return in_postfix_order(values["formula"], x, values["constants"])
    return np.interp(x, values["at"], values["torque"])


def folded(clock_s, values):
    """The clock within the period of a table; a formula goes on with the clock."""
    if "formula" in values:
        return clock_s
    begin, end = values["at"][0], values["at"][-1]
    return begin + (clock_s - begin) % (end - begin)


def formula_functions():
    """What a formula may call, by name."""
    return {
        "sin": np.sin, "cos": np.cos, "tanh": np.tanh, "exp": np.exp, "log": np.log,
        "sqrt": np.sqrt, "abs": np.abs, "sign": np.sign,
    }  # fmt: skip


def formula_operators():
    """What stands between two parts of a formula."""
    return {
        "+": np.add, "-": np.subtract, "*": np.multiply, "/": np.divide, "**": np.power,
    }  # fmt: skip


def in_postfix_order(postfix, x, values):
    """A formula of t2l at x: each function and operator takes what stands last."""
    functions, operators, stack = formula_functions(), formula_operators(), []
    for part in postfix.split():
        if part == "x":
            stack.append(x)
        elif part in values:
            stack.append(values[part])
        elif part in functions:
            stack.append(functions[part](stack.pop()))
        elif part in operators:
            second, first = stack.pop(), stack.pop()
            stack.append(operators[part](first, second))
        else:
            stack.append(np.float64(part))
    return stack[0]
