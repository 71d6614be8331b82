"""A formula as a tree: read from text, folded, and written with a unit for each constant.

Sums and products are flat, with their numbers gathered in front. Units follow from the tree: what
is added has the unit of the sum, and a sine, an exponential or a square takes a pure number.
"""

import ast
from dataclasses import dataclass, field

import numpy as np

from t2l.effects.expression import evaluate, parse

FUNCTIONS = {"sin": np.sin, "exp": np.exp}
Unit = tuple[int, int]  # exponents of N·m and of the variable's unit


@dataclass(frozen=True)
class Node:
    """`value`·Π parts (product), `value` + Σ parts (sum), a function of its part, or x, or |x|."""

    kind: str
    value: float = 1.0
    parts: tuple["Node", ...] = ()


def read(text: str) -> Node:
    """The tree of a formula in X1, the variable, and X2, its size.

    Raises:
        ValueError: it holds something else.
    """
    return _node(ast.parse(text.replace("^", "**"), mode="eval").body)


def _node(tree: ast.expr) -> Node:
    match tree:
        case ast.Constant(value=value):
            return Node("sum", float(value))
        case ast.Name(id="X1"):
            return Node("x")
        case ast.Name(id="X2"):
            return Node("abs")
        case ast.UnaryOp(op=ast.USub(), operand=part):
            return product([Node("sum", -1.0), _node(part)])
        case ast.BinOp(op=ast.Add(), left=left, right=right):
            return total([_node(left), _node(right)])
        case ast.BinOp(op=ast.Sub(), left=left, right=right):
            return total([_node(left), product([Node("sum", -1.0), _node(right)])])
        case ast.BinOp(op=ast.Mult(), left=left, right=right):
            return product([_node(left), _node(right)])
        case ast.BinOp(op=ast.Pow(), left=left, right=ast.Constant(value=2)):
            return applied("square", _node(left))
        case ast.Call(func=ast.Name(id=name), args=[part]) if name in FUNCTIONS:
            return applied(name, _node(part))
    raise ValueError(f"{ast.unparse(tree)}: found no formula of +, -, *, ^ 2, sin and exp")


def _number(node: Node) -> bool:
    return node.kind == "sum" and not node.parts


def total(parts: list[Node]) -> Node:
    """A sum, flat, with its numbers together."""
    value, rest = 0.0, []
    for part in parts:
        if part.kind == "sum":
            value += part.value
            rest += part.parts
        else:
            rest.append(part)
    rest = _alike_together(rest)
    return rest[0] if value == 0 and len(rest) == 1 else Node("sum", value, tuple(rest))


def _alike_together(parts: list[Node]) -> list[Node]:
    """Terms of a sum, those that differ in their number only as one."""
    numbers: dict[tuple[Node, ...], float] = {}
    for part in parts:
        factors = part.parts if part.kind == "product" else (part,)
        number = part.value if part.kind == "product" else 1.0
        numbers[factors] = numbers.get(factors, 0.0) + number
    return [
        f[0] if number == 1.0 and len(f) == 1 else Node("product", number, f)
        for f, number in numbers.items()
    ]


def product(parts: list[Node]) -> Node:
    """A product, likewise; a number is multiplied into a sum."""
    value, rest = 1.0, []
    for part in parts:
        if _number(part):
            value *= part.value
        elif part.kind == "product":
            value *= part.value
            rest += part.parts
        else:
            rest.append(part)
    if not rest or value == 0:
        return Node("sum", value if not rest else 0.0)
    if len(rest) == 1 and rest[0].kind == "sum":
        scaled = [product([Node("sum", value), part]) for part in rest[0].parts]
        return total([Node("sum", value * rest[0].value), *scaled])
    return rest[0] if value == 1 and len(rest) == 1 else Node("product", value, tuple(rest))


def applied(name: str, part: Node) -> Node:
    """A function of a tree."""
    if _number(part):
        value = part.value**2 if name == "square" else float(FUNCTIONS[name](part.value))
        return Node("sum", value)
    if name == "square" and part.kind == "product":
        factors = [applied("square", one) for one in part.parts]
        return product([Node("sum", part.value**2), *factors])
    return Node(name, 1.0, (part,))


@dataclass
class Formula:
    """Text in x and named constants, in the grammar of `t2l.effects.expression`.

    Attributes:
        values: of the constants, by name.
        units: their units.
    """

    text: str = ""
    values: dict[str, float] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)

    def __call__(self, x: np.ndarray, values: dict[str, float] | None = None) -> np.ndarray:
        """At x (n,)."""
        return evaluate(parse(self.text, self.values), np.asarray(x), values or self.values)

    def sentence(self, digits: int = 3) -> str:
        """For people: "a·sin(b·x + c), a = 0.05 N·m, …"."""
        text = self.text.replace(" * ", "·").replace("**2", "²")
        text = text.replace("abs(x)", "|x|")
        constants = (
            f"{name} = {value:.{digits}g}{' ' if self.units[name] else ''}{self.units[name]}"
            for name, value in self.values.items()
        )
        return f"{text}, {', '.join(constants)}"


def written(node: Node, unit: str, share: bool = False) -> Formula:
    """A tree as a formula of a torque, N·m, or a share of one, of a variable with `unit`."""
    formula = Formula()
    formula.text = _text(node, (0 if share else 1, 0), unit, formula)
    return formula


def _text(node: Node, wanted: Unit, unit: str, to: Formula) -> str:
    if node.kind == "sum":
        terms = [_text(part, wanted, unit, to) for part in node.parts]
        if node.value != 0 or not terms:
            terms.append(_constant(node.value, wanted, unit, to))
        return " + ".join(terms)
    parts = node.parts if node.kind == "product" else (node,)
    value = node.value if node.kind == "product" else 1.0
    has = (0, sum(part.kind in ("x", "abs") for part in parts))
    has = (0, has[1] + 2 * sum(_square_of_x(part) for part in parts))
    factors = [_factor(part, unit, to) for part in parts]
    rest = (wanted[0] - has[0], wanted[1] - has[1])
    if value != 1.0 or rest != (0, 0):
        factors.insert(0, _constant(value, rest, unit, to))
    return " * ".join(factors)


def _square_of_x(part: Node) -> bool:
    return part.kind == "square" and part.parts[0].kind in ("x", "abs")


def _factor(part: Node, unit: str, to: Formula) -> str:
    if part.kind == "x":
        return "x"
    if part.kind == "abs":
        return "abs(x)"
    if _square_of_x(part):
        return "x**2"
    inner = _text(part if part.kind == "sum" else part.parts[0], (0, 0), unit, to)
    return {"sum": f"({inner})", "square": f"({inner})**2"}.get(part.kind, f"{part.kind}({inner})")


def _constant(value: float, has: Unit, unit: str, to: Formula) -> str:
    name = "abcdefghijklmnopqrstuvw"[len(to.values)]
    to.values[name], to.units[name] = value, _unit(has, unit)
    return name


def _unit(has: Unit, unit: str) -> str:
    torque, power = has if unit else (has[0], 0)
    if unit == "N·m":
        torque, power, unit = torque + power, 0, ""
    above = "N·m" if torque == 1 else f"(N·m)^{torque}" if torque else ""
    if power == 0:
        return above
    digits = "" if abs(power) == 1 else "²³⁴⁵⁶⁷⁸⁹"[abs(power) - 2]
    name = f"({unit}){digits}" if "/" in unit and (digits or power < 0) else f"{unit}{digits}"
    if power > 0:
        return f"{above}·{name}" if above else name
    return f"{above or '1'}/{name}"
