"""Formulas of learned torques as a model file holds them: text that is read, and never executed."""

import re
from collections.abc import Callable, Sequence

from t2l.effects.expression import FUNCTIONS, VARIABLE
from t2l.effects.formula import Constant, FormulaLaw
from t2l.effects.law import INERTIA
from t2l.errors import ConfigurationError
from t2l.identify.curves import LawEntry, law_lines, read_law
from t2l.typed import Number, Typed, describe

MOST_CONSTANTS = 30  # bound: more is no short formula
NAME = r"[A-Za-z][A-Za-z0-9_]{0,30}"


class ConstantEntry(Typed):
    """One of `constants` of a formula."""

    unit: str = ""
    lower: Number
    upper: Number


class FormulaEntry(LawEntry):
    """One entry of `formulas` in a model file."""

    formula: str
    constants: dict[str, ConstantEntry]


def read_formulas(entries: Sequence[FormulaEntry]) -> tuple[FormulaLaw, ...]:
    """The formulas of a model file.

    Raises:
        ConfigurationError: a law, a formula or a constant is not allowed, or two laws are alike.
    """
    found: list[FormulaLaw] = []
    for number, entry in enumerate(entries):
        where = f"formulas.{number}"
        if entry.kind == INERTIA:
            raise ConfigurationError(
                f"{where}.kind: found {describe(entry.kind)}; allowed: a kind that is a function "
                "of its variable alone"
            )
        law = read_law(where, entry)
        constants = {
            name: _constant(f"{where}.constants.{name}", name, constant)
            for name, constant in entry.constants.items()
        }
        if not 1 <= len(constants) <= MOST_CONSTANTS:
            raise ConfigurationError(
                f"{where}.constants: found {len(constants)}; allowed: 1 to {MOST_CONSTANTS}"
            )
        one = FormulaLaw(law, entry.formula, constants, float(entry.ratio or 0.0))
        try:
            used = one.postfix.split()
        except ValueError as error:
            raise ConfigurationError(f"{where}.formula: found {error}") from None
        if unused := [name for name in constants if name not in used]:
            raise ConfigurationError(
                f"{where}.constants: found {', '.join(unused)}, which the formula does not use; "
                "allowed: those of the formula"
            )
        if one.name in [other.name for other in found]:
            raise ConfigurationError(f"{where}: found the same law twice; allowed: one formula")
        found.append(one)
    return tuple(found)


def _constant(where: str, name: str, entry: ConstantEntry) -> Constant:
    if not re.fullmatch(NAME, name) or name in (VARIABLE, *FUNCTIONS):
        raise ConfigurationError(
            f"{where}: found the name {describe(name)}; allowed: letters, digits and _, at most "
            f"31, beginning with a letter, and none of {', '.join((VARIABLE, *FUNCTIONS))}"
        )
    if not entry.lower < entry.upper:
        raise ConfigurationError(
            f"{where}: found lower {entry.lower:g} and upper {entry.upper:g}; allowed: lower "
            "below upper"
        )
    return Constant(entry.unit, float(entry.lower), float(entry.upper))


def formula_lines(
    formulas: Sequence[FormulaLaw], name: Callable[[str], str], number: Callable[..., str]
) -> list[str]:
    """Lines of YAML; `name` and `number` write a string and a number."""
    lines = ["formulas:"] if formulas else []
    for one in formulas:
        lines += [
            *law_lines(one.law, one.ratio, name, number),
            f"  formula: {name(one.text)}",
            "  constants:",
        ]
        lines += [
            f"    {name(key)}: {{unit: {name(constant.unit)}, lower: {number(constant.lower)}, "
            f"upper: {number(constant.upper)}}}"
            for key, constant in one.constants.items()
        ]
    return lines
