"""Hidden effects as t2l writes them in a model: its effects, its parameters, its signs."""

from collections.abc import Mapping, Sequence

from benchmarks.hidden_effects.effects import CONTACT_DAMPING_RATIO, CONTACT_FREQUENCY

# class in the generator: what t2l calls it, where that is another name
CALLED = {
    "HysteresisTorque": "maxwell_slip_friction",
    "TimeVaryingTorque": "free_running_torque",
}
# class in the generator: by parameter of t2l's effect the generator's number, the telling one first
ALIKE = {
    "Armature": {"inertia": "inertia"},
    "CoulombFriction": {"torque": "level"},
    "ViscousFriction": {"damping": "coefficient"},
    "QuadraticFriction": {"coefficient": "coefficient"},
    "TorqueOffset": {"torque": "offset"},
    "Cogging": {"periods": "periods", "amplitude": "amplitude", "phase": "phase"},
    "TorqueConstant": {"factor": "factor"},
    "CommandDelay": {"delay": "delay_s"},
    "ActuatorBandwidth": {"cutoff": "frequency_hz"},
    "TorqueSaturation": {"limit": "limit"},
    "TorqueRateLimit": {"rate": "rate"},
    "ControllerGains": {"kp_factor": "kp_factor", "kd_factor": "kd_factor"},
    "LowRateLoop": {"rate": "rate_hz"},
    "EncoderOffset": {"offset": "offset"},
    "JointFlexibility": {"stiffness": "stiffness", "damping": "damping"},
    "ParallelSpring": {"stiffness": "stiffness", "rest": "rest"},
    "BaseTilt": {"pitch": "pitch", "roll": "roll"},
    "IntegralAction": {"gain": "gain", "limit": "limit"},
    "VelocityFilter": {"cutoff": "frequency_hz"},
    "DahlFriction": {"coulomb": "coulomb", "presliding": "presliding"},
    "DirectionalFriction": {"forward": "forward", "backward": "backward"},
    "TorqueSpeedLimit": {"stall_torque": "stall_torque", "no_load_speed": "no_load_speed"},
    "PeriodicTorque": {"frequency": "frequency_hz", "amplitude": "amplitude", "phase": "phase"},
    "TimeVaryingTorque": {"frequency": "frequency_hz", "amplitude": "amplitude"},
    "FrictionDrift": {
        "at_end": "end_level", "at_start": "start_level", "time_constant": "time_constant_s",
    },
    "TorqueConstantDrift": {
        "at_end": "at_end", "at_start": "at_start", "time_constant": "time_constant_s",
    },
    "FrictionTemperature": {"torque": "level", "per_kelvin": "per_kelvin"},
    "TorqueConstantTemperature": {"per_kelvin": "per_kelvin"},
    "LoadDependentFriction": {"motor": "load_factor"},
    "Backlash": {"play": "width"},
}  # fmt: skip
# what t2l's effect has beside
BESIDE = {
    "LowRateLoop": {"phase": 0.0},
    "TorqueRateLimit": {"ramp": 1.0},
    "Backlash": {
        "contact_time": 1 / CONTACT_FREQUENCY,
        "contact_damping": CONTACT_DAMPING_RATIO,
    },
}


def numbers(entry: Mapping, joints: Sequence[str], links: Mapping[str, str]) -> dict | None:
    """Parameters of t2l's effect, a number or one by joint each; None if they have no such form.

    Args:
        entry: of `hidden` in truth.yaml.
        links: by joint the link that it moves.
    """
    kind = entry["effect"]
    if kind == "ClockOffset":
        return {"offset": -entry["early_s"]}
    if kind == "LinkInertia":
        (joint,) = [joint for joint, link in links.items() if link == entry["link"]]
        shift = dict(zip(("com_x", "com_y", "com_z"), entry["shift"], strict=True))
        values = {name: entry[name] for name in ("mass_factor", "inertia_factor")} | shift
        return {name: {joint: value} for name, value in values.items()}
    if kind == "JointCoupling":
        i, j = joints.index(entry["joint"]), joints.index(entry["other"])
        k, r = entry["stiffness"], entry["ratio"]
        own = {"stiffness": k, "damping": entry["damping"], "ratio": r, "rest": entry["rest"]}
        if i < j:  # of the later of the two
            own = {
                "stiffness": k * r**2, "damping": entry["damping"] * r**2, "ratio": 1 / r,
                "rest": entry["rest"] / r,
            }  # fmt: skip
        own["before"] = abs(i - j)
        return {name: {joints[max(i, j)]: value} for name, value in own.items()}
    if kind in ("StribeckFriction", "LugreFriction"):
        extra = {j: entry["static"][j] - level for j, level in entry["coulomb"].items()}
        found = {"coulomb": entry["coulomb"], "extra_at_rest": extra, "velocity": entry["velocity"]}
        if kind == "LugreFriction":
            presliding = {j: level / entry["stiffness"][j] for j, level in entry["coulomb"].items()}
            found |= {"presliding": presliding, "damping": entry["damping"]}
        return found
    if kind == "HysteresisTorque":  # three elements alike, that slip at parts of its width
        found = {}
        for k, part in enumerate((0.25, 0.5, 1.0), start=1):
            found[f"torque_{k}"] = {j: a / 3 for j, a in entry["amplitude"].items()}
            found[f"radius_{k}"] = {j: part * entry["width"] for j in entry["amplitude"]}
        return found
    if kind == "Payload":
        return {"mass": entry["mass"]} | dict(
            zip(("com_x", "com_y", "com_z"), entry["com"], strict=True)
        )
    if kind not in ALIKE:
        return None
    found = {ours: entry[theirs] for ours, theirs in ALIKE[kind].items()} | BESIDE.get(kind, {})
    if kind in ("JointFlexibility", "Backlash"):
        found["encoder_on_link"] = float(entry["encoder_side"] == "link")
    return found
