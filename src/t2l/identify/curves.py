"""Learned curves as a model file holds them."""

from collections.abc import Callable, Sequence
from math import ceil, log10
from pathlib import Path
from typing import Annotated, Literal

import numpy as np

from t2l.effects.law import ALLOWED, INERTIA, LIMIT, OTHERS, TENDON, TORQUE, Curve, Law
from t2l.errors import ConfigurationError
from t2l.typed import AsTuple, Number, Typed, describe

FEWEST, MOST = 2, 2000  # bound: values of a curve
LEAST_STEP = 1e-9  # numerics: from value to value; slopes stay finite, and no sensor tells less
DIGITS = 6  # format: of a number, of the range of a curve
SHARE = "of the motor torque"


class LawEntry(Typed):
    """Where a law acts and what it follows, as a model file says it."""

    kind: Literal["torque", "friction", "motor", "inertia", "limit", "tendon"]
    joint: str
    follows: str
    of: str | None = None
    ratio: Number | None = None


class CurveEntry(LawEntry):
    """One entry of `learned` in a model file."""

    at: Annotated[tuple[Number, ...], AsTuple]
    torque: Annotated[tuple[Number, ...], AsTuple]


def read_curves(entries: Sequence[CurveEntry]) -> tuple[Curve, ...]:
    """The curves of a model file.

    Raises:
        ConfigurationError: what a curve follows or its values are not allowed, or two are alike.
    """
    curves = []
    for number, entry in enumerate(entries):
        where = f"learned.{number}"
        law = read_law(where, entry)
        _check_values(where, law, entry.at, entry.torque)
        if law in [curve.law for curve in curves]:
            raise ConfigurationError(f"{where}: found the same law twice; allowed: one curve each")
        values = (tuple(map(float, column)) for column in (entry.at, entry.torque))
        curves.append(Curve(law, *values, float(entry.ratio or 0.0)))
    return tuple(curves)


def read_law(where: str, entry: LawEntry) -> Law:
    """The law of an entry.

    Args:
        where: the entry stands, for messages.

    Raises:
        ConfigurationError: what it follows, or whose, is not allowed.
    """
    law = Law(entry.kind, entry.joint, entry.follows, entry.of or entry.joint)
    if law.follows not in ALLOWED[law.kind]:
        raise ConfigurationError(
            f"{where}.follows: found {describe(law.follows)}; allowed for {law.kind}: "
            f"{', '.join(ALLOWED[law.kind])}"
        )
    _check_tendon(where, law, entry.ratio)
    if law.of != law.joint and not (law.kind in (TORQUE, TENDON) and law.follows in OTHERS):
        raise ConfigurationError(
            f"{where}.of: found {describe(law.of)}; allowed: {law.joint}, or another joint for "
            f"a torque or tendon that follows {' or '.join(OTHERS)}"
        )
    return law


def _check_tendon(where: str, law: Law, ratio: float | None) -> None:
    if law.kind != TENDON:
        if ratio is not None:
            raise ConfigurationError(
                f"{where}.ratio: found {describe(ratio)}; allowed: only for a tendon"
            )
        return
    if law.of == law.joint:
        raise ConfigurationError(
            f"{where}.of: found {describe(law.of)}; allowed for a tendon: another joint than "
            f"{law.joint}"
        )
    if not ratio:
        raise ConfigurationError(
            f"{where}.ratio: found {describe(ratio)}; allowed for a tendon: a number other than 0, "
            f"the lever arm at {law.of} over that at {law.joint}"
        )


def _check_values(where: str, law: Law, at: Sequence[float], torque: Sequence[float]) -> None:
    if len(at) != len(torque) or not FEWEST <= len(at) <= MOST:
        raise ConfigurationError(
            f"{where}: found {len(at)} values of at and {len(torque)} of torque; allowed: as many "
            f"of each, {FEWEST} to {MOST}"
        )
    if not (np.diff(at) > 0).all():
        raise ConfigurationError(f"{where}.at: found values that do not increase; allowed: rising")
    least = np.diff(at).min()
    if least < LEAST_STEP:
        unit = f" {law.unit}" if law.unit else ""
        raise ConfigurationError(
            f"{where}.at: found values {least:.3g}{unit} apart; allowed: at least "
            f"{LEAST_STEP:g}{unit}"
        )
    if law.kind == LIMIT:
        _check_limit(where, Curve(law, tuple(map(float, at)), tuple(map(float, torque))))
    if law.kind == INERTIA and len(at) != FEWEST:
        raise ConfigurationError(
            f"{where}: found {len(at)} values of an inertia; allowed: the {FEWEST} ends of a "
            "straight line"
        )


def _check_limit(where: str, curve: Curve) -> None:
    """Beyond its no-load speed a motor brakes; at rest and against the motion no limit drives it.

    Raises:
        ConfigurationError: such a limit.
    """
    speed = np.array([0.0, *(x for x in curve.at if x < 0)])
    most = curve(speed)
    worst = int(np.argmin(most))
    if most[worst] < 0:
        raise ConfigurationError(
            f"{where}.torque: found a limit of {most[worst]:.3g} N·m at {speed[worst]:.3g} rad/s, "
            "which drives the motor backwards; allowed: 0 N·m or more at rest and below it"
        )


def check_law_joints(
    path: Path | str, key: str, laws: Sequence[Law], joints: Sequence[str], whose: str
) -> None:
    """Find laws of joints that are not there.

    Args:
        key: of the model file that holds them.
        whose: joints they are, for messages.

    Raises:
        ConfigurationError: such a joint.
    """
    for number, law in enumerate(laws):
        for which, name in (("joint", law.joint), ("of", law.of)):
            if name not in joints:
                raise ConfigurationError(
                    f"{path}: {key}.{number}.{which} names joint {name!r}; {whose} "
                    f"{', '.join(joints)}"
                )


def law_lines(
    law: Law, ratio: float, name: Callable[[str], str], number: Callable[..., str]
) -> list[str]:
    """Lines of YAML of where a law acts and what it follows, as the first of an entry."""
    return [
        f"- kind: {law.kind}",
        f"  joint: {name(law.joint)}",
        f"  follows: {law.follows}",
        f"  of: {name(law.of)}",
        *([f"  ratio: {number(ratio)}"] if law.kind == TENDON else []),
    ]


def as_lines(
    curves: Sequence[Curve], name: Callable[[str], str], number: Callable[..., str]
) -> list[str]:
    """Lines of YAML; `name` and `number` write a string and a number."""
    lines = ["learned:"] if curves else []
    for curve in curves:
        law = curve.law
        # a clock may count from 1970
        far = np.abs(curve.at).max() / np.ptp(curve.at)
        at = [number(value, DIGITS + max(0, ceil(log10(far)))) for value in curve.at]
        lines += [
            *law_lines(law, curve.ratio, name, number),
            f"  at: [{', '.join(at)}]" + (f"  # {law.unit}" if law.unit else ""),
            f"  torque: [{', '.join(map(number, curve.torque))}]  # {law.torque_unit or SHARE}",
        ]
    return lines
