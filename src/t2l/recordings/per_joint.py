"""Numbers for joints in what people write: one for all of them, or one for each."""

import math
from typing import Annotated, Any

import numpy as np
from pydantic import PlainValidator, ValidationInfo

from t2l.typed import describe, is_number, refuse


def per_joint(
    above: float = -math.inf,
    at_least: float = -math.inf,
    unit: str = "",
    one_for_all: bool = True,
) -> Any:
    """The type of a key that becomes an array (njoint,).

    How many joints there are is known from a key `joints` before it, or is the context that
    `t2l.typed.check` is given.
    """

    def validate(value: Any, info: ValidationInfo) -> np.ndarray | None:
        count = info.context if info.context is not None else len(info.data.get("joints", ()))
        bounds = f" above {above:g}" if above > -math.inf else ""
        bounds = f" from {at_least:g} up" if at_least > -math.inf else bounds
        each = f"{count}, one for each joint" + (f", in {unit}" if unit else "")
        allowed = f"one number{bounds}, or {each}"
        if not one_for_all:
            allowed = f"{count} numbers{bounds}, {each.partition(', ')[2]}"
        numbers = value if isinstance(value, list) else [value] if one_for_all else []
        if not numbers or any(not is_number(n) or n <= above or n < at_least for n in numbers):
            raise refuse(allowed, describe(value))
        # joints that are wrong themselves are told instead
        if count == 0:
            return None
        if isinstance(value, list) and len(numbers) != count:
            raise refuse(allowed, f"{len(numbers)} number{'s' if len(numbers) > 1 else ''}")
        return np.array(numbers * (count if len(numbers) == 1 else 1), dtype=float)

    return Annotated[Any, PlainValidator(validate, json_schema_input_type=float | list[float])]
