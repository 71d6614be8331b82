"""Effects taken out of t2l's library one at a time: the curves that are learned in their place.

`python -m benchmarks proposals [--propose] [--processes N] [--test-seed N | --mixed]
[--curves FILE] [CASE or KIND ...]`: each case hides one effect, made by a generator that shares no
code with t2l. `t2l explain` has all known effects but those that would name it (`--without`): it
shows whether another name is adopted in its place, and what is learned. With `--mixed` a case hides
an effect besides that the library keeps: it should be named. With `--propose` it is learned without
any known effect. Each case is kept in results/bench/proposals until the code changes that explains
it, so that an interrupted table goes on where it stopped.
"""

import argparse
import contextlib
import json
import re
import shutil
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from time import perf_counter

import pandas as pd
import yaml

from benchmarks import learned_curves, one_core
from benchmarks.hidden import PROCESSES, code_key
from benchmarks.hidden_effects import effects as fx
from benchmarks.hidden_effects import real_effects as rx
from benchmarks.hidden_effects.cases import ARM, PENDULUM, ROBOTS, Case, is_complete, make
from benchmarks.hidden_effects.drawn_cases import drawn
from benchmarks.scene import ROOT

FOLDER = ROOT / "results/bench/proposals"
TWICE = 2.0  # times the noise that a learned function of one variable may leave

SHORT = {"duration_s": 3.0, "physics_rate_hz": 4000}
HANGING = SHORT | {"gravity_compensation": False}
ELBOW, BOTH, HINGE = ("elbow",), ("shoulder", "elbow"), ("hinge",)

# dry friction, and what is dry friction for some values of its parameters
DRY = (
    "coulomb_friction",
    "dahl_friction",
    "directional_friction",
    "friction_drift",
    "friction_temperature",
    "load_dependent_friction",
    "lugre_friction",
    "maxwell_slip_friction",
    "stribeck_friction",
)
# a cable that is wound on one joint alone is a spring and a damper
SPRING = ("parallel_spring", "joint_coupling")
# a shifted centre of mass, a leaning base and a shifted encoder do the same to a weight
WEIGHT = ("base_tilt", "encoder_offset", "link_inertia", "payload")
# the gains of a loop without other torques
CONSTANT = (
    "torque_constant",
    "torque_constant_drift",
    "torque_constant_temperature",
    "controller_gains",
)
SLIDES = ("speed", "velocity", "constant")
GRAVITY = ("position", "load", "constant")
# M(1 + a) q̈ + D q̇ + G(1 + a) = τ: a heavier link is a motor that lacks a share of its torque, and
# a heavier pendulum one that lacks the same share of its friction
HEAVIER = (*GRAVITY, "acceleration", "commanded torque")
HEAVIER_OF = {PENDULUM: (*HEAVIER, "velocity"), ARM: HEAVIER}


@dataclass(frozen=True)
class Removed:
    """An effect that the library lacks, and what is right to say of it.

    Args:
        kind: of the effect.
        case: that hides it.
        without: names to take away, all that say the same.
        joints: on which a torque is right, and whose motion it may follow.
        follows: variables that it may follow; none if it is no torque of a variable.
        one_variable: whether it is a function of one logged variable, as a law of t2l may be.
        besides: names that are true: what is hidden besides, or a part of the effect's own torque.
        also: joints on which what is hidden besides acts, and what it follows: a law may take its
            place.
    """

    kind: str
    case: Case
    without: tuple[str, ...]
    joints: tuple[str, ...]
    follows: tuple[str, ...]
    one_variable: bool
    besides: tuple[str, ...] = ()
    also: tuple[tuple[str, ...], tuple[str, ...]] = ((), ())


# kind, what is hidden on a pendulum, on an arm, the joints of the arm, the names that say the
# same, what the torque follows, whether it is a function of that alone
KINDS = (
    (
        "viscous", fx.ViscousFriction(0.03), fx.ViscousFriction({"elbow": 0.08}), ELBOW,
        ("viscous_friction", "joint_coupling"), ("velocity", "speed"), True,
    ),
    (
        "quadratic", fx.QuadraticFriction(0.02), fx.QuadraticFriction({"elbow": 0.04}), ELBOW,
        ("quadratic_friction",), ("velocity", "speed"), True,
    ),
    (
        "cogging", fx.Cogging(0.05, 14.0), fx.Cogging({"elbow": 0.06}, 20.0, 0.7), ELBOW,
        ("cogging",), ("position",), True,
    ),
    (
        "coulomb", fx.CoulombFriction(0.06), fx.CoulombFriction({"elbow": 0.05}), ELBOW,
        DRY, SLIDES, True,
    ),
    (
        "offset", fx.TorqueOffset(0.03), fx.TorqueOffset({"elbow": -0.05}), ELBOW,
        ("torque_offset",), ("constant",), True,
    ),
    (
        "spring", rx.ParallelSpring(0.15, 0.3), rx.ParallelSpring({"elbow": 0.3}, 0.8), ELBOW,
        SPRING, ("position",), True,
    ),
    (
        "bump", fx.OddPositionTorque(0.06, 0.5, 0.1, 0.3, 0.6),
        fx.OddPositionTorque({"elbow": 0.06}, 1.0, 0.1, 0.8, 0.5), ELBOW,
        (), ("position",), True,
    ),
    (
        "periodic", rx.TorqueSinceStart(0.04, 0.73), rx.TorqueSinceStart({"elbow": 0.05}, 0.9),
        ELBOW, ("periodic_torque",), ("time", "session time", "phase"), True,
    ),
    (
        # of a pendulum alone it is a function of the position
        "tilt", rx.BaseTilt(0.0, -0.2), rx.BaseTilt(0.0, 0.1), BOTH, WEIGHT, GRAVITY, HINGE,
    ),
    (
        "mass", rx.LinkInertia("bar", 1.3, (0.0, 0.0, -0.01), 1.2),
        rx.LinkInertia("forearm", 1.3, (0.0, 0.0, -0.03)), BOTH,
        (*WEIGHT, "armature"), HEAVIER_OF, False,
    ),
    (
        "integral", rx.IntegralAction(15.0, 0.4), rx.IntegralAction(8.0, 1.5), BOTH,
        ("integral_action",), (), False,
    ),
    (
        "velocity_filter", rx.VelocityFilter(12.0), rx.VelocityFilter(12.0), BOTH,
        ("velocity_filter",), (), False,
    ),
    (
        "coupling", None, rx.JointCoupling("elbow", "shoulder", 1.0, -0.8, 0.3, 0.02), BOTH,
        ("joint_coupling",), ("position", "velocity"), False,
    ),
    (
        "dahl", rx.DahlFriction(0.15, 0.03), rx.DahlFriction({"elbow": 0.08}, 0.01), ELBOW,
        DRY, ("distance", *SLIDES), False,
    ),
    (
        "lugre", rx.LugreFriction(0.06, 0.14, 0.15, 17.5, 0.2),
        rx.LugreFriction({"elbow": 0.05}, {"elbow": 0.12}, 0.15, 15.0, 0.2), ELBOW,
        DRY, ("distance", *SLIDES), False,
    ),
    (
        # dry friction beside a constant torque
        "directional", rx.DirectionalFriction(0.05, 0.2),
        rx.DirectionalFriction({"elbow": 0.1}, {"elbow": 0.03}), ELBOW,
        (*DRY, "torque_offset"), SLIDES, True,
    ),
    (
        "speed_limit", rx.TorqueSpeedLimit(1.2, 8.0, 12.6, 0.1),
        rx.TorqueSpeedLimit({"elbow": 1.2}, {"elbow": 10.0}), ELBOW,
        ("torque_speed_limit",), ("velocity", "speed", "commanded torque"), False,
    ),
    (
        "friction_drift", rx.FrictionDrift(0.08, 0.02, 10.0),
        rx.FrictionDrift({"elbow": 0.02}, {"elbow": 0.1}, 15.0), ELBOW,
        DRY, ("session time", "time"), True,
    ),
    (
        "friction_warmth", rx.FrictionTemperature(level=0.06, per_kelvin=-1e-3),
        rx.FrictionTemperature(level=0.05, per_kelvin=2e-3), BOTH,
        DRY, ("time", "temperature"), True,
    ),
    (
        "constant_drift", rx.TorqueConstantDrift(1.0, 0.85, 15.0),
        rx.TorqueConstantDrift(1.05, 0.7, 20.0), BOTH,
        CONSTANT, ("commanded torque", "load", "session time", "time"), False,
    ),
    (
        "constant_warmth", rx.TorqueConstantTemperature(per_kelvin=-4e-3),
        rx.TorqueConstantTemperature(per_kelvin=-4e-3), BOTH,
        CONSTANT, ("commanded torque", "load", "time", "temperature"), False,
    ),
    (
        "clock", rx.ClockOffset(0.003), rx.ClockOffset(0.02), BOTH, ("clock_offset",), (), False,
    ),
)  # fmt: skip
# −k (q + r q' − q0) − d (q̇ + r q̇'): on each joint a cable is a spring, a damper and a constant
# torque, beside what follows the other joint
PARTS = {"coupling": ("parallel_spring", "viscous_friction", "torque_offset")}
# what is taken out, where, and what is hidden besides: its name in the library, what it follows
MIXED = (
    ("bump", PENDULUM, "viscous_friction", SLIDES, fx.ViscousFriction(0.02)),
    ("bump", ARM, "coulomb_friction", SLIDES, fx.CoulombFriction({"shoulder": 0.06})),
    ("cogging", PENDULUM, "torque_offset", ("constant",), fx.TorqueOffset(0.04)),
    ("spring", PENDULUM, "coulomb_friction", SLIDES, fx.CoulombFriction(0.05)),
    ("spring", ARM, "cogging", ("position",), fx.Cogging({"shoulder": 0.06}, 14.0)),
    ("coulomb", ARM, "viscous_friction", SLIDES, fx.ViscousFriction({"elbow": 0.05})),
    ("viscous", PENDULUM, "coulomb_friction", SLIDES, fx.CoulombFriction(0.05)),
    ("viscous", ARM, "parallel_spring", ("position",), rx.ParallelSpring({"shoulder": 0.4}, 0.3)),
    ("offset", PENDULUM, "torque_constant", ("commanded torque", "load"), fx.TorqueConstant(0.9)),
    ("periodic", ARM, "viscous_friction", SLIDES, fx.ViscousFriction({"shoulder": 0.1})),
    ("tilt", PENDULUM, "coulomb_friction", SLIDES, fx.CoulombFriction(0.05)),
    ("mass", ARM, "coulomb_friction", SLIDES, fx.CoulombFriction({"elbow": 0.05})),
    ("coupling", ARM, "coulomb_friction", SLIDES, fx.CoulombFriction({"shoulder": 0.06})),
    ("friction_drift", PENDULUM, "cogging", ("position",), fx.Cogging(0.05, 14.0)),
    ("dahl", ARM, "armature", ("acceleration",), fx.Armature({"shoulder": 0.05})),
    ("constant_warmth", PENDULUM, "viscous_friction", SLIDES, fx.ViscousFriction(0.02)),
)
# of test sets that are drawn from a seed: their kinds, by the names above
DRAWN = {
    "viscous_friction": "viscous",
    "quadratic_friction": "quadratic",
    "cogging": "cogging",
    "coulomb_friction": "coulomb",
    "torque_offset": "offset",
    "parallel_spring": "spring",
    "periodic_torque": "periodic",
    "base_tilt": "tilt",
    "link_inertia": "mass",
    "integral_action": "integral",
    "velocity_filter": "velocity_filter",
    "joint_coupling": "coupling",
    "dahl_friction": "dahl",
    "lugre_friction": "lugre",
    "directional_friction": "directional",
    "torque_speed_limit": "speed_limit",
    "friction_drift": "friction_drift",
    "friction_temperature": "friction_warmth",
    "torque_constant_drift": "constant_drift",
    "torque_constant_temperature": "constant_warmth",
    "clock_offset": "clock",
}
# kinds whose effect shows more where the arm hangs by its motors
HANGS = ("integral", "constant_drift", "constant_warmth", "tilt", "mass")


def cases(test_seed: int | None = None) -> dict[str, Removed]:
    """By name: every kind on a pendulum and on an arm, or what a seed draws."""
    if test_seed is not None:
        return _drawn(test_seed)
    table = {}
    for kind, on_pendulum, on_arm, joints, names, follows, one_variable in KINDS:
        for robot, hidden in ((PENDULUM, on_pendulum), (ARM, on_arm)):
            if hidden is None:
                continue
            name = f"{kind}_{robot}"
            where = HINGE if robot == PENDULUM else joints
            changes = HANGING if kind in HANGS and robot == ARM else SHORT
            case = Case(name, robot, (hidden,), zlib.crc32(name.encode()), changes)
            one = where == HINGE if one_variable is HINGE else one_variable
            follow, parts = _of(follows, robot), PARTS.get(kind, ())
            table[name] = Removed(kind, case, names, where, follow, one, parts)
    return table


def mixed() -> dict[str, Removed]:
    """By name: cases of which something is hidden besides that the library knows."""
    table, development = {}, cases()
    for kind, robot, known, follows, effect in MIXED:
        alone = development[f"{kind}_{robot}"]
        name = f"mixed_{kind}_{robot}"
        hidden, seed = (*alone.case.hidden, effect), zlib.crc32(name.encode())
        case = replace(alone.case, name=name, hidden=hidden, seed=seed)
        also, besides = (_joints(robot, (effect,)), follows), (*alone.besides, known)
        table[name] = replace(alone, case=case, besides=besides, also=also)
    return table


def _drawn(seed: int) -> dict[str, Removed]:
    """Sizes, joints, motions and flaws of the log drawn; the effects of `KINDS` that can be."""
    known, table = {kind: rest for kind, *rest in KINDS}, {}
    for name, robot, hidden, number, changes in drawn(seed):
        kind = DRAWN.get(next((k for k in DRAWN if name.startswith(f"test{seed}_{k}_")), ""))
        if kind is None:
            continue
        _, _, _, names, follows, one_variable = known[kind]
        one = robot == PENDULUM if one_variable is HINGE else one_variable
        case = Case(name, robot, hidden, number, SHORT | changes)
        joints = _joints(robot, hidden)
        follow, parts = _of(follows, robot), PARTS.get(kind, ())
        table[name] = Removed(kind, case, names, joints, follow, one, parts)
    return table


def _of(follows: tuple | dict, robot: str) -> tuple[str, ...]:
    """The variables of a kind, which may depend on the robot."""
    return follows[robot] if isinstance(follows, dict) else follows


def _joints(robot: str, hidden: Sequence[fx.HiddenEffect]) -> tuple[str, ...]:
    """Those that an effect gives numbers to one by one; otherwise all of the robot."""
    values = [value for effect in hidden for value in vars(effect).values()]
    given = {joint for value in values if isinstance(value, dict) for joint in value}
    return tuple(given) or ROBOTS[robot].joints


def case_of(name: str) -> Removed:
    """A case of either set."""
    if name.startswith("mixed_"):
        return mixed()[name]
    seed = re.match(r"test(\d+)_", name)
    return cases(int(seed[1]) if seed else None)[name]


def main(arguments: Sequence[str]) -> pd.DataFrame:
    """What the command line asks for."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks proposals", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="CASE", help="cases or kinds (default: all)")
    parser.add_argument("--propose", action="store_true", help="learn without any known effect")
    one_core.add_processes(parser, PROCESSES)
    seed = "the test set that is drawn from this number, in place of the development cases"
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--test-seed", type=int, metavar="N", help=seed)
    which.add_argument("--mixed", action="store_true", help="cases that hide a known effect too")
    picture = "draw what was learned of functions of one variable, beside what is hidden"
    parser.add_argument("--curves", type=Path, metavar="FILE", help=picture)
    given = parser.parse_args(arguments)
    command = "propose" if given.propose else "explain"
    every, of = (mixed(), "_mixed") if given.mixed else (cases(given.test_seed), "")
    if given.test_seed is not None:
        of = f"_test{given.test_seed}"
    return run(every, given.names, given.processes, command, f"table{of}", given.curves)


def run(
    every: Mapping[str, Removed],
    names: Sequence[str] = (),
    processes: int = PROCESSES,
    command: str = "explain",
    name: str = "table",
    curves: Path | None = None,
) -> pd.DataFrame:
    """One row a case; the table by kind and a summary are printed above.

    Args:
        curves: picture to make of what was learned of functions of one variable.
    """
    unknown = set(names) - set(every) - {removed.kind for removed in every.values()}
    if unknown:
        raise SystemExit(f"no case or kind {', '.join(sorted(unknown))}; there are {list(every)}")
    chosen = [n for n, removed in every.items() if not names or {n, removed.kind} & set(names)]
    results = []
    for result in one_core.each(partial(judged, command), chosen, processes):
        results.append(result)
        print(f"{len(results)} of {len(chosen)}: {result['case']}, {said(result)}", flush=True)
    table = pd.DataFrame([row(result) for result in results])
    table.to_csv(FOLDER / command / f"{name}.csv", index=False)
    print("\n" + by_kind(results).to_markdown(index=False))
    print("\n" + "\n".join(summary(results)) + "\n")
    if curves is not None:
        pairs = [(case_of(result["case"]), result) for result in results]
        learned_curves.draw([(one.case, r) for one, r in pairs if one.one_variable], curves)
    return table


def judged(command: str, name: str) -> dict:
    """A case's result, from its file or made now."""
    removed = case_of(name)
    path = FOLDER / command / "results" / f"{name}.json"
    made_by = {"key": code_key(), "truth": removed.case.truth(), "without": list(removed.without)}
    if path.exists():
        kept = json.loads(path.read_text())
        if {key: kept[key] for key in made_by} == json.loads(json.dumps(made_by)):
            return kept
    where, out = FOLDER / "cases" / name, FOLDER / command / "work" / name
    if not is_complete(removed.case, where):
        make(removed.case, where)
    shutil.rmtree(out, ignore_errors=True)
    began = perf_counter()
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(path.with_suffix(".log"), "w") as log, contextlib.redirect_stdout(log):
        content, adopted = found(command, where, out, removed.without)
    result = {
        **made_by,
        "case": name,
        "adopted": adopted,
        "verdict": content["verdict"],
        "curves": content["curves"],
        "before": content["report"]["baseline_rmse_q_rad"],
        "after": content["report"]["rmse_q_rad"],
        "in_words": content["report"].get("formulas_rmse_q_rad"),
        "noise_floor": content["noise_floor_rad"],
        "seconds": perf_counter() - began,
    }
    path.write_text(json.dumps(result, indent=1, ensure_ascii=False))
    return json.loads(path.read_text())


def found(command: str, where: Path, out: Path, without: tuple[str, ...]) -> tuple[dict, list[str]]:
    """What is proposed, and the names that the model adopts."""
    from t2l.cli.main import main
    from t2l.effects.registry import builtin

    taken = [name for name in without if name in builtin()]
    logs = [str(where / "train"), "--holdout", str(where / "holdout"), "--out", str(out)]
    if command == "propose":
        main([command, *logs])
        return json.loads((out / "proposal.json").read_text()), []
    main([command, *logs, *(f"--without={name}" for name in taken)])
    model = yaml.safe_load((out / "model.yaml").read_text())
    return _proposed(out), list(model["effects"])


def _proposed(out: Path) -> dict:
    """The curves beside an explanation; without any, what the explanation says itself."""
    if (out / "proposal" / "proposal.json").exists():
        return json.loads((out / "proposal" / "proposal.json").read_text())
    told = json.loads((out / "explanation.json").read_text())
    errors = (told["steps"][at]["test_rmse_q_rad"] for at in (0, -1))
    report = dict(zip(("baseline_rmse_q_rad", "rmse_q_rad"), errors, strict=True))
    floor, verdict = told["noise_floor_rad"], told["verdict"]
    return {"curves": [], "noise_floor_rad": floor, "verdict": verdict, "report": report}


def said(result: dict) -> str:
    """What is proposed, in words."""
    return "; ".join(curve["law"] for curve in result["curves"]) or result["verdict"]


def wrong_names(result: dict) -> list[str]:
    """Adopted names of effects that are not there."""
    besides = case_of(result["case"]).besides
    return [name for name in result["adopted"] if name not in besides]


def right(result: dict) -> bool | None:
    """Whether joint and variable are right; None where no torque of a variable is."""
    removed = case_of(result["case"])
    if not removed.follows:
        return None

    def told(curve: dict, joints: Sequence[str], follows: Sequence[str]) -> bool:
        return {curve["joint"], curve["of"]} <= set(joints) and curve["follows"] in follows

    sought = [told(curve, removed.joints, removed.follows) for curve in result["curves"]]
    others = [told(curve, *removed.also) for curve in result["curves"]]
    return any(sought) and all(one or other for one, other in zip(sought, others, strict=True))


def near(result: dict) -> bool | None:
    """Whether at most twice the noise is left; None where no function of one variable could.

    With the formulas of laws that have one: they are what is read, edited and adopted.
    """
    if not case_of(result["case"]).one_variable:
        return None
    left = result["in_words"] or result["after"]
    return left <= TWICE * result["noise_floor"]


def row(result: dict) -> dict:
    """What the table shows, errors in mrad."""
    words = {True: "yes", False: "NO", None: ""}
    wrong = wrong_names(result)
    formulas = [curve["formula"] for curve in result["curves"] if curve["formula"]]

    def mrad(value: float) -> str:
        return f"{1e3 * value:.3f}"

    return {
        "case": result["case"],
        "right names": ", ".join(name for name in result["adopted"] if name not in wrong),
        "wrong names": ", ".join(wrong),
        "proposed": said(result),
        "right": words[right(result)],
        "before": mrad(result["before"]),
        "after": mrad(result["after"]),
        "with formulas": mrad(result["in_words"]) if result["in_words"] else "",
        "noise": mrad(result["noise_floor"]),
        "within twice": words[near(result)],
        "formula": "; ".join(formula["sentence"] for formula in formulas),
        "seconds": f"{result['seconds']:.0f}",
    }


def by_kind(results: Sequence[dict]) -> pd.DataFrame:
    """A row a kind: how many are right, what is left, which names are adopted."""
    rows: dict[str, list[dict]] = {}
    for result in results:
        rows.setdefault(case_of(result["case"]).kind, []).append(result)

    def share(answers: Sequence[bool | None]) -> str:
        asked = [answer for answer in answers if answer is not None]
        return f"{sum(asked)} of {len(asked)}" if asked else ""

    def mrad(group: Sequence[dict], key: str) -> str:
        return ", ".join(f"{1e3 * result[key]:.3f}" for result in group)

    return pd.DataFrame(
        {
            "hidden": kind,
            "joint and variable right": share([right(result) for result in group]),
            "wrong names": ", ".join(name for result in group for name in wrong_names(result)),
            "before, mrad": mrad(group, "before"),
            "after": mrad(group, "after"),
            "noise": mrad(group, "noise_floor"),
            "within twice the noise": share([near(result) for result in group]),
        }
        for kind, group in rows.items()
    )


def summary(results: Sequence[dict]) -> list[str]:
    """The aims and how far they are met."""
    lines = []
    for what, answers in (
        ("joint and variable right", [right(result) for result in results]),
        ("at most twice the noise, functions of one variable", [near(r) for r in results]),
        ("no wrong name adopted", [not wrong_names(result) for result in results]),
    ):
        asked = [answer for answer in answers if answer is not None]
        if asked:
            lines.append(f"{what}: {sum(asked)} of {len(asked)} ({sum(asked) / len(asked):.0%})")
    return lines
