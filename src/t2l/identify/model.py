"""The model so far: a robot and the effects adopted with their values, as YAML a person edits.

robot: arm.xml             # an MJCF path relative to this file, or a known name
effects:
  coulomb_friction:
    torque: {shoulder: 0.52, elbow: 0.61}            # N·m
  command_delay:
    delay: 0.012                                     # s
effect_files: [my_effects/rubber.py]                 # optional, relative to this file; Python
learned:                                             # optional, curves that t2l propose learned
- kind: torque                                       # torque, friction or motor
  joint: elbow
  follows: position
  of: elbow
  at: [-0.5, 0.0, 0.5]                               # rad
  torque: [0.1, 0.0, -0.1]                           # N·m
formulas:                                            # optional, values under effects
- kind: torque
  joint: elbow
  follows: position
  of: elbow
  formula: a * sin(b * x)                            # in x, what it follows, and constants
  constants:
    a: {unit: N·m, lower: -0.5, upper: 0.5}          # bounds of fits
    b: {unit: 1/rad, lower: -90, upper: 90}
"""

import json
import math
import os
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Annotated

import mujoco
import numpy as np
from pydantic import Field

from t2l.artefacts import write_text
from t2l.documents import is_text, read_yaml, to_yaml
from t2l.effects.effect import Effect, Parameter, Scales, within
from t2l.effects.expression import evaluate
from t2l.effects.formula import FormulaLaw, FormulaTorque
from t2l.effects.law import LIMIT, Curve
from t2l.effects.learned import LearnedTorque
from t2l.effects.registry import load as load_effects
from t2l.effects.spline_torque import SplineTorque
from t2l.effects.term import Layout, Term
from t2l.errors import ConfigurationError
from t2l.identify.curves import DIGITS, CurveEntry, as_lines, check_law_joints, read_curves
from t2l.identify.formulas import FormulaEntry, formula_lines, read_formulas
from t2l.recordings.recording import Recording
from t2l.registry import check_trusted, python_files
from t2l.robots import ROBOTS
from t2l.robots.plant import compiled, load, mjcf_path
from t2l.typed import AsTuple, Invalid, Number, Typed, check, describe

Values = Mapping[str, Mapping[str, Mapping[str, float] | float]]


@dataclass(frozen=True)
class Model:
    """A robot and the effects it has beyond its MJCF.

    Attributes:
        robot: a known name or the absolute path of an MJCF file.
        effects: ``effects[name][parameter]`` is a number, or one for each joint by name.
        effect_files: files of effects of the user's own.
        learned: curves that were learned from recordings.
        without: names of effects that are not to be known; no file holds them.
        formulas: laws that are effects too, of their own names.
        sizes: of the recordings that it is fitted to, which scaled bounds are multiples of; see
            `t2l.identify.scales.sized`. No file holds them.
    """

    robot: str
    effects: Values = field(default_factory=dict)
    effect_files: tuple[Path, ...] = ()
    learned: tuple[Curve, ...] = ()
    without: tuple[str, ...] = ()
    formulas: tuple[FormulaLaw, ...] = ()
    sizes: Scales | None = field(default=None, compare=False, repr=False)

    def known_effects(self, joints: tuple[str, ...] = ()) -> dict[str, Effect]:
        """Every effect this model may use, within what is possible for `joints` of the robot."""
        own = {formula.name: FormulaTorque(formula) for formula in self.formulas}
        known = load_effects(self.effect_files) | own
        known = {name: effect for name, effect in known.items() if name not in self.without}
        if not joints:
            return known
        bare = _bare(self.robot, joints, mjcf_path(self.robot).stat().st_mtime_ns)
        sizes = self.sizes if self.sizes and self.sizes.joints == joints else None
        return {
            name: within(effect, bare, joints, sizes, self.effects.get(name))
            for name, effect in known.items()
        }

    def everywhere(self, joints: tuple[str, ...]) -> set[str]:
        """Names of the adopted effects that every joint has."""
        return {term.effect.name for term in self.terms(joints) if len(term.joints) == len(joints)}

    def missing_effects(
        self, joints: tuple[str, ...], recordings: Sequence[Recording] = ()
    ) -> list[Effect]:
        """Known effects that some joint does not have yet, and that the recordings can fit."""
        # a formula is of the joints of its law alone
        has = self.everywhere(joints) | {formula.name for formula in self.formulas}
        return [
            effect
            for name, effect in self.known_effects(joints).items()
            if name not in has and (not recordings or effect.may_act(recordings))
        ]

    def terms(self, joints: tuple[str, ...]) -> list[Term]:
        """The adopted effects on the joints they have values for."""
        known = self.known_effects(joints)
        return [
            Term(known[name], _joints_with_values(values, known[name], joints))
            for name, values in self.effects.items()
        ] + [Term(LearnedTorque(curve), (joints.index(curve.law.joint),)) for curve in self.learned]

    def vector(self, joints: tuple[str, ...]) -> tuple[Layout, np.ndarray]:
        """Layout and parameter vector u of the adopted effects."""
        terms = self.terms(joints)
        values = {
            term.effect.name: {
                p.name: _as_array(self.effects[term.effect.name][p.name], term, p, joints)
                for p in term.effect.parameters
            }
            for term in terms
        }
        layout = Layout(terms)
        return layout, layout.encode(values)


@lru_cache(maxsize=8)
def _bare(robot: str, joints: tuple[str, ...], written: int) -> mujoco.MjModel:
    """The robot without effects, of a file that was last `written` then."""
    return compiled(load(robot, joints), robot)


def from_vector(model: Model, layout: Layout, u: np.ndarray, joints: tuple[str, ...]) -> Model:
    """`model` with the effects of a layout in place of its own, splines as curves."""
    values = layout.decode(u[None])
    effects = {
        term.effect.name: {
            p.name: (
                {
                    joints[j]: float(v)
                    for j, v in zip(term.joints, values[term.effect.name][p.name][0], strict=True)
                }
                if p.per_joint
                else float(values[term.effect.name][p.name][0, 0])
            )
            for p in term.effect.parameters
        }
        for term in layout.terms
        if not isinstance(term.effect, LearnedTorque | SplineTorque)
    }
    learned = [t.effect.curve for t in layout.terms if isinstance(t.effect, LearnedTorque)]
    for effect in (t.effect for t in layout.terms if isinstance(t.effect, SplineTorque)):
        learned.append(effect.curve([values[effect.name][p.name][0, 0] for p in effect.parameters]))
    return replace(model, effects=effects, learned=tuple(learned))


def merged_with(merged: Model | None, model: Model, name: str) -> Model:
    """`merged`, or `model` where there is none yet, with what `model` says of effect `name`."""
    base = merged or model
    effects = {**base.effects, **({name: model.effects[name]} if name in model.effects else {})}
    files = tuple(dict.fromkeys((*base.effect_files, *model.effect_files)))
    learned = {curve.law: curve for curve in (*model.learned, *base.learned)}
    formulas = {one.name: one for one in (*model.formulas, *base.formulas) if one.name in effects}
    return Model(
        base.robot, effects, files, tuple(learned.values()), formulas=tuple(formulas.values()),
        sizes=base.sizes,
    )  # fmt: skip


def _joints_with_values(values, effect: Effect, joints: tuple[str, ...]) -> tuple[int, ...]:
    for parameter in effect.parameters:
        if parameter.per_joint:
            return tuple(j for j, name in enumerate(joints) if name in values[parameter.name])
    return tuple(range(len(joints)))


def _as_array(value, term: Term, parameter: Parameter, joints: tuple[str, ...]) -> np.ndarray:
    if parameter.per_joint:
        return np.array([value[joints[j]] for j in term.joints])
    return np.array([value])


def read_model(
    path: Path | str, without: tuple[str, ...] = (), trusted: Collection[Path] = ()
) -> Model:
    """Read a model file.

    Args:
        without: names of effects that are not to be known, which no file holds.
        trusted: absolute paths of Python files that may run if the model names them.

    Raises:
        ConfigurationError: the file is missing or not YAML; a key, robot, effect, parameter or
            value is not allowed; it names a Python file that is not trusted.
    """
    path = Path(path)
    content = read_yaml(path, "a model file")
    try:
        found = check(ModelFile, content)
        robot = _read_robot(found.robot, path.parent)
        files = tuple((path.parent / file).resolve() for file in found.effect_files or ())
        check_trusted(python_files(files), "effect_files", trusted)
        formulas = read_formulas(found.formulas or ())
        known = Model(robot, {}, files, formulas=formulas).known_effects()
        effects = _with_defaults(found.effects or {}, known)
        _check_effects(effects, known)
        model = Model(robot, effects, files, without=without, formulas=formulas)
        _check_formulas(model)
        learned = read_curves(found.learned or ())
    except (Invalid, ConfigurationError) as error:
        raise ConfigurationError(f"{path}: {error}") from None
    return replace(model, learned=learned)


def read_again(path: Path, model: Model) -> Model:
    """A model that was written in the course of a run that began with `model`.

    The folder may have come from elsewhere: no other Python file than those of `model` is run.

    Raises:
        ConfigurationError: as `read_model`.
    """
    found = read_model(path, model.without, python_files(model.effect_files))
    return replace(found, sizes=model.sizes)


class ModelFile(Typed):
    """A model file as it is written; `_check_effects` knows what each effect may hold."""

    robot: Annotated[str, Field(min_length=1, description="a known name, or the path of an MJCF")]
    effects: dict[str, dict[str, Number | dict[str, Number]]] | None = None
    effect_files: Annotated[tuple[str, ...], AsTuple] | None = None
    learned: Annotated[tuple[CurveEntry, ...], AsTuple] | None = None
    formulas: Annotated[tuple[FormulaEntry, ...], AsTuple] | None = None


def _read_robot(robot: str, folder: Path) -> str:
    if robot in ROBOTS.names():
        return robot
    resolved = str((folder / robot).resolve())
    mjcf_path(resolved)
    return resolved


def _with_defaults(effects: object, known: Mapping[str, Effect]) -> object:
    """Effects with what a file may leave out, on the joints that it names."""
    if not isinstance(effects, dict):
        return effects
    found = {}
    for name, values in effects.items():
        found[name] = values
        for p in known[name].parameters if name in known and isinstance(values, dict) else ():
            if p.name not in values and math.isfinite(p.default):
                on = next((v for v in values.values() if isinstance(v, dict)), {})
                default = dict.fromkeys(on, p.default) if p.per_joint else p.default
                found[name] = {**found[name], p.name: default}
    return found


def _check_effects(effects: object, known: Mapping[str, Effect]) -> None:
    if not isinstance(effects, dict):
        raise ConfigurationError("effects must map names to parameters")
    for name, values in effects.items():
        if name not in known:
            raise ConfigurationError(
                f"effects: unknown effect {name!r}; known: {', '.join(sorted(known))}"
            )
        names = {p.name for p in known[name].parameters}
        if not isinstance(values, dict) or set(values) != names:
            raise ConfigurationError(
                f"effects.{name} must have exactly the parameters "
                f"{', '.join(p.name for p in known[name].parameters)}"
            )
        joints, first = None, ""
        for p in known[name].parameters:
            where = f"effects.{name}.{p.name}"
            _check_value(where, p, values[p.name])
            if p.per_joint:
                if joints is not None and set(values[p.name]) != joints:
                    other = ", ".join(sorted(map(str, joints)))
                    raise ConfigurationError(
                        f"{where} has values for {', '.join(map(str, values[p.name]))}; "
                        f"effects.{name}.{first} for {other}"
                    )
                joints, first = set(values[p.name]), p.name


def _check_formulas(model: Model) -> None:
    for number, formula in enumerate(model.formulas):
        if formula.name not in model.effects:
            raise ConfigurationError(
                f"formulas.{number}: found no values; allowed: one for each of its constants under "
                f"effects.{formula.name}"
            )
        values = {
            name: value[formula.law.joint] if isinstance(value, dict) else value
            for name, value in model.effects[formula.name].items()
            if not isinstance(value, dict) or formula.law.joint in value
        }
        if formula.law.kind == LIMIT and len(values) == len(formula.constants):
            (at_rest,) = evaluate(formula.postfix, np.zeros(1), values)
            if not at_rest >= 0:
                raise ConfigurationError(
                    f"formulas.{number}: found a limit of {at_rest:.3g} N·m at rest, which drives "
                    "the motor backwards; allowed: 0 N·m or more"
                )
        for name, value in model.effects[formula.name].items():
            if isinstance(value, dict) and set(value) != {formula.law.joint}:
                raise ConfigurationError(
                    f"effects.{formula.name}.{name}: found values for {', '.join(value)}; "
                    f"allowed: for {formula.law.joint}, the joint of formulas.{number}"
                )


def _check_value(where: str, parameter: Parameter, value: object) -> None:
    if parameter.per_joint != isinstance(value, dict) or value == {}:
        wanted = "one number for each joint" if parameter.per_joint else "one number"
        raise ConfigurationError(f"{where} must be {wanted}")
    possible = parameter.in_units()
    for number in value.values() if isinstance(value, dict) else [value]:
        if isinstance(number, bool) or not isinstance(number, (int, float)):
            raise ConfigurationError(f"{where}: {describe(number)} is not a number")
        lower, upper = possible.lower, possible.upper
        above_zero = possible.log and lower == 0
        if not (math.isfinite(number) and lower <= number <= upper) or (above_zero and number == 0):
            allowed = f"{lower} to {upper}" if math.isfinite(upper) else "0 or more"
            allowed = "more than 0" if above_zero else allowed
            allowed = allowed if lower > -math.inf else "a finite number"
            raise ConfigurationError(f"{where} = {number} {parameter.unit}; allowed {allowed}")


def check_joints(
    path: Path | str, model: Model, joints: tuple[str, ...], whose: str = "the recordings have"
) -> None:
    """Find values for other joints; `whose` these are, for messages.

    Raises:
        ConfigurationError: such a value.
    """
    for name, values in model.effects.items():
        for parameter, value in values.items():
            for joint in value if isinstance(value, dict) else ():
                if joint not in joints:
                    raise ConfigurationError(
                        f"{path}: effects.{name}.{parameter} names joint {joint!r}; {whose} "
                        f"{', '.join(joints)}"
                    )
    known = model.known_effects()
    for name, values in model.effects.items():
        try:
            known[name].check(joints, values)
        except ValueError as error:
            raise ConfigurationError(f"{path}: effects.{name}: {error}") from None
    for key, laws in (("learned", model.learned), ("formulas", model.formulas)):
        check_law_joints(path, key, [one.law for one in laws], joints, whose)


def write_model(model: Model, path: Path | str, comment: str = "") -> None:
    """Write a model file, whole, with paths relative to it and units as comments."""
    path = Path(path)
    known, here = model.known_effects(), path.resolve().parent
    robot = model.robot if model.robot in ROBOTS.names() else os.path.relpath(model.robot, here)
    lines = [f"# {_comment(comment)}"] if comment else []
    lines += [f"robot: {_name(robot)}"]
    lines += ["effects:" if model.effects else "effects: {}"]
    for name, values in model.effects.items():
        effect = known[name]
        lines += [f"  {_name(name)}:  # {_comment(effect.summary)}"]
        for p in effect.parameters:
            value = values[p.name]
            text = (
                "{" + ", ".join(f"{_name(j)}: {_number(v)}" for j, v in value.items()) + "}"
                if isinstance(value, Mapping)
                else _number(value)
            )
            lines += [f"    {_name(p.name)}: {text}  # {_comment(f'{p.unit}, {p.meaning}')}"]
    if model.effect_files:
        files = [_name(os.path.relpath(file, here)) for file in model.effect_files]
        lines += [f"effect_files: [{', '.join(files)}]"]
    lines += as_lines(model.learned, _name, _number)
    present = [formula for formula in model.formulas if formula.name in model.effects]
    lines += formula_lines(present, _name, _number)
    write_text("\n".join(lines) + "\n", path)


def _name(text: str) -> str:
    """A string as YAML reads it back: quoted where it would become something else."""
    plain = re.fullmatch(r"[A-Za-z_./][\w./-]*", text) and is_text(text)
    if plain:
        return text
    return to_yaml(text, default_style='"', allow_unicode=True, width=math.inf).strip()


def _comment(text: str) -> str:
    """Text that ends with its line: names in it may hold a line break, or what YAML refuses."""
    return "".join(c if c.isprintable() else json.dumps(c)[1:-1] for c in text)


def _number(value: float, digits: int = DIGITS) -> str:
    """Digits that count; YAML takes 1e-05 for a string and 1.0e-05 for a number."""
    text = f"{value:.{digits}g}"
    return text.replace("e", ".0e") if "e" in text and "." not in text else text
