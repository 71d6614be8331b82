"""robot.py and robot.json, which stand beside an exported MJCF and need MuJoCo and numpy only.

The program is `t2l.export.robot` as it is, with the functions of effects behind it. Names, numbers
and formulas of a model are data in the JSON: no text of a model becomes program.
"""

import inspect
from typing import Any

import numpy as np

from t2l.effects.exported import Exported
from t2l.errors import EffectError
from t2l.export import robot


def robot_text(to: Exported) -> str:
    """robot.py of an exported robot.

    Raises:
        EffectError: functions or numbers of effects have the same name and differ.
    """
    program = inspect.getsource(robot)
    if not to.callbacks:
        return program
    functions = "\n\n".join(_sources(to))
    called = dict.fromkeys(call.function.__name__ for call in to.callbacks)
    named = ", ".join(f'"{name}": {name}' for name in called)
    return f"{program}\n\n{functions}\n\nFUNCTIONS.update({{{named}}})\n"


def robot_data(to: Exported) -> dict[str, Any]:
    """What robot.json holds of an exported robot."""
    return {
        "joints": list(to.joints),
        "encoder_offset": to.encoder_offset.tolist(),
        "constant": to.constant.tolist(),
        "read_too": [entry[1:] for entry in to.read_too],
        "compensated": _compensated(to),
        "callbacks": [
            {
                "function": call.function.__name__,
                "joints": list(call.joints),
                "values": _plain(call.values),
                "on": call.on,
                "stateless": call.stateless,
            }
            for call in to.callbacks
        ],
    }


def _compensated(to: Exported) -> tuple[list[float], dict[str, tuple[float, list[float]]]] | None:
    """What robot.py's gravity compensation goes by, where that is not the exported model."""
    if not to.compensates_another:
        return None
    known, real = to.known_to_loop, to.spec.compile()
    other = [
        body
        for body in range(known.nbody)
        if known.body_mass[body] != real.body_mass[body]
        or (known.body_ipos[body] != real.body_ipos[body]).any()
    ]
    links = {
        known.body(body).name: (float(known.body_mass[body]), known.body_ipos[body].tolist())
        for body in other
    }
    return known.opt.gravity.tolist(), links


def _sources(to: Exported) -> list[str]:
    """Texts of the callbacks and of what they use.

    Raises:
        EffectError: two of the same name differ.
    """
    found: dict[str, tuple[str, str]] = {}
    for call in to.callbacks:
        for name, text in call.sources.items():
            effect, known = found.setdefault(name, (call.effect, text))
            if text != known:
                raise EffectError(
                    f"effects {effect} and {call.effect}: to export them, found two functions or "
                    f"numbers {name!r} that differ; allowed: one of a name"
                )
    return [text for _, text in found.values()]


def _plain(value: Any) -> Any:
    """Numbers, texts and arrays, also in mappings, as JSON has them."""
    if isinstance(value, dict):
        return {str(name): _plain(one) for name, one in value.items()}
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value
