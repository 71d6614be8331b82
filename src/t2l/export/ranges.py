"""What the uncertainty of a model makes of MuJoCo's parameters: ranges for domain randomisation."""

from typing import Any

import mujoco
import numpy as np

from t2l.effects.exported import Exported
from t2l.export.mjcf import Controller, export
from t2l.identify.model import Model
from t2l.identify.uncertainty import Uncertainty

# fields of MjModel that are parameters; others follow from them. What a row of each is named by
FIELDS = {
    "body_mass": mujoco.mjtObj.mjOBJ_BODY,
    "body_ipos": mujoco.mjtObj.mjOBJ_BODY,
    "body_inertia": mujoco.mjtObj.mjOBJ_BODY,
    "qpos0": mujoco.mjtObj.mjOBJ_JOINT,
    "jnt_stiffness": mujoco.mjtObj.mjOBJ_JOINT,
    "jnt_range": mujoco.mjtObj.mjOBJ_JOINT,
    "jnt_solref": mujoco.mjtObj.mjOBJ_JOINT,
    "jnt_actfrcrange": mujoco.mjtObj.mjOBJ_JOINT,
    "dof_armature": mujoco.mjtObj.mjOBJ_JOINT,
    "dof_damping": mujoco.mjtObj.mjOBJ_JOINT,
    "dof_dampingpoly": mujoco.mjtObj.mjOBJ_JOINT,
    "dof_frictionloss": mujoco.mjtObj.mjOBJ_JOINT,
    "tendon_stiffness": mujoco.mjtObj.mjOBJ_TENDON,
    "tendon_damping": mujoco.mjtObj.mjOBJ_TENDON,
    "tendon_frictionloss": mujoco.mjtObj.mjOBJ_TENDON,
    "actuator_gainprm": mujoco.mjtObj.mjOBJ_ACTUATOR,
    "actuator_biasprm": mujoco.mjtObj.mjOBJ_ACTUATOR,
    "actuator_dynprm": mujoco.mjtObj.mjOBJ_ACTUATOR,
    "actuator_delay": mujoco.mjtObj.mjOBJ_ACTUATOR,
}


def ranges(model: Model, controller: Controller, found: Uncertainty) -> dict[str, Any]:
    """95 % ranges of what the effects are made of, and of MjModel's fields that they move.

    Each effect's parameter is moved to either end of its interval alone; a field's range is the
    widest that this gives it. One that the data do not determine is listed without a range.
    """
    layout, u = found.layout, found.u
    nominal = _compiled(export(model, controller, layout, u))
    parameters, low, high = [], dict(nominal), dict(nominal)
    for i, slot in enumerate(layout.slots):
        interval = found.interval(i) if np.isfinite(found.error[i]) else None
        parameters.append(
            {
                "effect": slot.term.effect.name,
                "parameter": slot.parameter.name,
                "unit": slot.parameter.unit,
                "joint": None if slot.joint is None else controller.joints[slot.joint],
                "value": float(layout.theta(u)[i]),
                "range": None if interval is None else list(interval),
            }
        )
        for end in interval or ():
            moved = u.copy()
            moved[i] = np.log(end) if layout.log[i] else end
            for key, value in _compiled(export(model, controller, layout, moved)).items():
                low[key] = min(low.get(key, value), value)
                high[key] = max(high.get(key, value), value)
    fields = [
        {"field": field, "name": name, "index": index, "value": nominal[key],
         "range": [low[key], high[key]]}
        for key in nominal
        if high[key] > low[key]
        for field, name, index in [key]
    ]  # fmt: skip
    return {"parameters": parameters, "mjmodel": fields}


def _compiled(to: Exported) -> dict[tuple[str, str, int], float]:
    """Numbers of the compiled model by field, name of the row, and index in it."""
    model = to.spec.compile()
    numbers = {}
    for field, kind in FIELDS.items():
        rows = np.asarray(getattr(model, field))
        for row, values in enumerate(rows.reshape(len(rows), -1) if rows.size else ()):
            name = _name(model, field, kind, row)
            for index, value in enumerate(values):
                numbers[field, name, index] = float(value)
    return numbers


def _name(model: mujoco.MjModel, field: str, kind: mujoco.mjtObj, row: int) -> str:
    if field.startswith("dof_"):
        row = model.dof_jntid[row]
    return mujoco.mj_id2name(model, kind, row) or str(row)
