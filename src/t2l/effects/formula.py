"""A learned torque as a formula with constants that can be fitted: data, which nothing executes."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from t2l.effects.effect import Parameter
from t2l.effects.expression import evaluate, parse
from t2l.effects.law import LIMIT, TENDON, Law
from t2l.effects.learned import Lawful, acting

SIZE = (
    0.01  # numerics: of the way between the bounds of a constant, a value that makes a difference
)
# by what a law follows: the condition of `t2l.diagnose.conditions` that its error follows
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


@dataclass(frozen=True)
class Constant:
    """A number of a formula: its unit, and how far fits may move it."""

    unit: str
    lower: float
    upper: float


@dataclass(frozen=True)
class FormulaLaw:
    """A law with what it says, in the grammar of `t2l.effects.expression`.

    Attributes:
        text: in x, the law's variable, and the constants; as the values of a curve.
        constants: by name.
        ratio: of a tendon: the lever arm at joint `of` over that at `joint`.
    """

    law: Law
    text: str
    constants: Mapping[str, Constant]
    ratio: float = 0.0

    @property
    def name(self) -> str:
        """Of the effect that it is."""
        return self.law.plain_name("formula")

    @cached_property
    def postfix(self) -> str:
        """The text as `evaluate` takes it.

        Raises:
            ValueError: the text is no formula of the constants.
        """
        return parse(self.text, self.constants)


class FormulaTorque(Lawful):
    """The effect of a formula on the joint, or the joints, of its law."""

    title = "formula of a learned torque"
    source = "t2l propose, from recordings"

    def __init__(self, formula: FormulaLaw):
        law = formula.law
        super().__init__(law)
        self.formula, self.name = formula, formula.name
        self.summary = law.words
        self.signature = f"the error follows the {law.follows} of {law.of}"
        self.follows = CONDITIONS.get(law.follows, "") if law.of == law.joint else ""
        tendon = law.kind == TENDON
        self.coupled, self.least_joints = tendon, 1 + tendon
        self.parameters = tuple(
            Parameter(
                name, constant.unit, constant.lower, constant.upper, f"{name} of the formula",
                neutral=_absent(law, constant.unit), per_joint=not tendon,
                size=SIZE * (constant.upper - constant.lower) / 2,
            )
            for name, constant in formula.constants.items()
        )  # fmt: skip

    def starts(self, scales):
        return [{p.name: np.array([p.size]) for p in self.parameters}]

    def install(self, loop, rows, joints, values):
        constants = {name: value[:, 0] for name, value in values.items()}
        postfix = self.formula.postfix
        acting(
            loop, rows, self.law, lambda x: evaluate(postfix, x, constants), self.formula.ratio
        )  # fmt: skip

    def carried(self, to, values):
        constants = {name: float(np.ravel(value)[0]) for name, value in values.items()}
        own = {"formula": self.formula.postfix, "constants": constants}
        return own | {"ratio": self.formula.ratio}


def _absent(law: Law, unit: str) -> float:
    """The value of a constant at which nothing acts: none of a limit, where zero is not none."""
    is_torque = law.kind != LIMIT and (unit == "N·m" or unit.startswith("N·m/"))
    return 0.0 if is_torque else np.nan
