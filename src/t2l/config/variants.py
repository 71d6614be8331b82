"""Variants of behaviour cloning: what differs from the nominal, one by one.

A variant is checked as the whole configuration that it stands for.
"""

from collections.abc import Iterator, Mapping
from typing import Any

from t2l.bc.collections import FOLDER
from t2l.config.models import Configuration
from t2l.config.models.cloning import Variant
from t2l.config.training import configuration_model
from t2l.typed import Invalid, Problem, check

NOMINAL = "nominal"
SECTIONS = tuple(Variant.model_fields)
# names of folders beside those of variants
TAKEN = (NOMINAL, "demonstrations", "fidelity", "noise")


def configurations(
    config: Mapping[str, Any], nominal: Configuration
) -> tuple[dict[str, Configuration], list[Problem]]:
    """The configuration that each variant stands for, the nominal first, and what is wrong.

    Args:
        config: as it was written.
        nominal: `config`, checked.
    """
    made, problems = {NOMINAL: nominal}, []
    for name, variant in nominal.variants.items():
        changes = variant.model_dump(exclude_none=True)
        if name in TAKEN or name.startswith(FOLDER):
            problems.append(Problem(f"variants.{name}", "a name that is taken", "another name"))
            continue
        problems += _of_recording(name, changes)
        try:
            made[name] = _checked(config, changes)
        except Invalid as error:
            problems += [_inside(name, problem) for problem in error.problems]
    return made, problems


def differing(name: str, problems: list[Problem], of_nominal: list[Problem]) -> Iterator[Problem]:
    """Those of a variant's problems that the nominal does not have."""
    known = set(map(str, of_nominal))
    return (_inside(name, problem) for problem in problems if str(problem) not in known)


def _checked(config: Mapping[str, Any], changes: Mapping[str, Any]) -> Configuration:
    whole = {key: value for key, value in config.items() if key != "variants"}
    for section, keys in changes.items():
        before = whole.get(section) or {}
        # of another policy, no key of the nominal's
        keeps = section != "training" or keys.get("policy", before.get("policy")) == before.get(
            "policy"
        )
        whole[section] = {**before, **keys} if keeps else keys
    return check(configuration_model(whole), whole)


def _of_recording(name: str, changes: Mapping[str, Any]) -> Iterator[Problem]:
    for key in changes.get("demonstrations", {}):
        if key != "used":
            yield Problem(
                f"variants.{name}.demonstrations.{key}", "what all variants share", "used"
            )


def _inside(name: str, problem: Problem) -> Problem:
    return Problem(f"variants.{name}.{problem.key}", problem.found, problem.allowed)
