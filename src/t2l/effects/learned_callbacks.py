"""What an exported robot runs before each timestep for a learned torque."""

import numpy as np


def learned_law(robot, joints, values):
    """Add what is looked up in a table: a torque, or the level of dry friction."""
    of, at = values["of"], values["at"]
    x = {
        "constant": 0.0,
        "position": robot.angle[of],
        "velocity": robot.velocity[of],
        "speed": abs(robot.velocity[of]),
        "commanded torque": robot.motor[of],
        "commanded torque size": abs(robot.motor[of]),
        "load": robot.load[of],
        "time": robot.data.time + 0.5 * robot.period_s,
        "phase": at[0] + (robot.data.time + 0.5 * robot.period_s - at[0]) % (at[-1] - at[0]),
    }[values["follows"]]
    adds_to = robot.friction if values["kind"] == "friction" else robot.torque
    adds_to[joints] += np.interp(x, at, values["torque"])


def learned_tendon(robot, joints, values):
    """Pull at two joints by what is looked up in a table."""
    joint, of, ratio = values["joint"], values["of"], values["ratio"]
    x = robot.angle if values["follows"] == "position" else robot.velocity
    tension = np.interp(x[joint] + ratio * x[of], values["at"], values["torque"])
    robot.torque[joint] += tension
    robot.torque[of] += ratio * tension


def learned_limit(robot, joints, values):
    """Cut what goes beyond a limit that is looked up in a table."""
    dq, at, most = robot.dq[joints], values["at"], values["torque"]
    least, greatest = -np.interp(-dq, at, most), np.interp(dq, at, most)
    robot.motor[joints] = np.clip(robot.motor[joints], least, greatest)


def learned_hysteresis(robot, joints, values):
    """Add elastic-plastic elements that remember."""
    q, radii = robot.angle[joints[0]], values["radii"]
    anchors = robot.state.get("anchors", q)
    stretch = np.clip(q - anchors, -radii, radii)
    robot.state["anchors"] = q - stretch
    robot.torque[joints] -= np.sum(values["weights"] * stretch / radii)
