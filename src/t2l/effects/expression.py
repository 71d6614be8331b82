"""Formulas as data: text of a closed grammar, read once and evaluated without running any of it.

    a * sin(b * x + c)

A formula holds numbers, the names that it may use, ``+ - * / **``, brackets and the functions of
`FUNCTIONS`. It is kept in postfix order ("a b x * c + sin *"), which one loop evaluates; an
exported robot has the same loop.
"""

import ast
from collections.abc import Collection, Mapping

import numpy as np

from t2l.effects.learned_callbacks import formula_functions, in_postfix_order

VARIABLE = "x"
FUNCTIONS = tuple(formula_functions())
MOST_CHARACTERS = 500  # bound: a longer one is no short formula, and Python's parser nests deeply
SHOWN_CHARACTERS = 80  # format: of what is wrong
OPERATORS = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Pow: "**"}
GRAMMAR = f"numbers, names, + - * / **, brackets, {', '.join(FUNCTIONS)}"


def parse(text: str, names: Collection[str]) -> str:
    """A formula in postfix order, with a space between any two of its parts.

    Args:
        names: of constants that it may use beside `VARIABLE`.

    Raises:
        ValueError: it is longer than `MOST_CHARACTERS`, or holds something else.
    """
    if len(text) > MOST_CHARACTERS:
        raise ValueError(f"{len(text)} characters; allowed: at most {MOST_CHARACTERS}")
    try:
        # no line of Python begins with a space
        tree = ast.parse(text.strip(), mode="eval")
        return " ".join(_postfix(tree.body, {VARIABLE, *names}))
    except (SyntaxError, OverflowError, RecursionError, MemoryError):
        shown = repr(text[:SHOWN_CHARACTERS])
        raise ValueError(f"{shown}, which is no formula; allowed: {GRAMMAR}") from None


def _postfix(tree: ast.expr, names: Collection[str]) -> list[str]:
    match tree:
        case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
            # a float at once: whole numbers of Python grow without end
            return [repr(float(value))]
        case ast.Name(id=name) if name in names:
            return [name]
        case ast.UnaryOp(op=ast.USub(), operand=part):
            return ["-1.0", *_postfix(part, names), "*"]
        case ast.BinOp(left=left, op=op, right=right) if type(op) in OPERATORS:
            return [*_postfix(left, names), *_postfix(right, names), OPERATORS[type(op)]]
        case ast.Call(func=ast.Name(id=name), args=[part], keywords=[]) if name in FUNCTIONS:
            return [*_postfix(part, names), name]
    shown = ast.unparse(tree)[:SHOWN_CHARACTERS]
    raise ValueError(f"{shown!r}; allowed: {GRAMMAR}, of the names {', '.join(sorted(names))}")


def evaluate(postfix: str, x: np.ndarray, values: Mapping[str, np.ndarray | float]) -> np.ndarray:
    """A formula at x, of its shape where the values are numbers; what is not defined is NaN."""
    with np.errstate(all="ignore"):
        return in_postfix_order(postfix, x, values) + 0.0 * x
