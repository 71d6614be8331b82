"""What keys of behaviour cloning must be in view of each other and of the tasks."""

from collections.abc import Iterator, Mapping
from math import pi

from t2l.config.actions import of_actions
from t2l.config.models import Configuration
from t2l.policies import POLICIES
from t2l.tasks import Demonstrated, Task
from t2l.typed import Problem, describe, suggestion


def problems(configuration: Configuration, tasks: Mapping[str, Task]) -> Iterator[Problem]:
    """Everything that is wrong between them.

    Args:
        tasks: those of the study that could be made, by name.
    """
    yield from _operator(configuration)
    yield from _cloned(configuration, tasks)
    yield from _cameras(configuration, tasks)


def _operator(configuration: Configuration) -> Iterator[Problem]:
    section = configuration.operator
    if section is None:
        return
    for i, crossover in enumerate(section.crossover_rad_s):
        # beyond it, a loop of an integrator and this delay corrects ever more
        if crossover * section.reaction_s >= pi / 2:
            most = pi / 2 / section.reaction_s
            yield Problem(
                f"operator.crossover_rad_s[{i}]",
                describe(crossover),
                f"a number below π/2 / operator.reaction_s = {most:.4g}",
            )


def _cloned(configuration: Configuration, tasks: Mapping[str, Task]) -> Iterator[Problem]:
    for i, name in enumerate(configuration.tasks):
        if name in tasks and not isinstance(tasks[name], Demonstrated):
            yield Problem(f"tasks[{i}]", describe(name), "a task that an expert can demonstrate")
        elif name in tasks:
            yield from _unseen(configuration, name, tasks[name])
    yield from of_actions("actions", configuration.actions)


def _cameras(configuration: Configuration, tasks: Mapping[str, Task]) -> Iterator[Problem]:
    wanted, policy = configuration.observation.cameras, configuration.training.policy
    if wanted and not POLICIES.find(policy).sees_pictures:
        allowed = f"none, as {policy} sees no pictures"
        yield Problem("observation.cameras", describe(wanted), allowed)
    if wanted and configuration.operator is not None:
        allowed = "none with an operator, whose demonstrations differ from cell to cell"
        yield Problem("observation.cameras", describe(wanted), allowed)
    for key in () if wanted else POLICIES.find(policy).picture_settings:
        if value := getattr(configuration.training, key):
            allowed = "0, as observation.cameras are none"
            yield Problem(f"training.{key}", describe(value), allowed)
    # a scene is read again for its cameras, so only where they matter
    for name in configuration.tasks if wanted else ():
        known = tasks[name].cameras if name in tasks else wanted
        for i, camera in enumerate(wanted):
            if camera not in known:
                found = f"{describe(camera)}{suggestion(camera, known)}"
                allowed = ", ".join(known) or "none"
                yield Problem(f"observation.cameras[{i}]", found, f"{allowed}, cameras of {name}")


def _unseen(configuration: Configuration, name: str, task: Task) -> Iterator[Problem]:
    """Parts of an observation that a policy needs, and what it is trained on has not."""
    seen, policy = task.robot_observation_size, configuration.training.policy
    cameras = configuration.observation.cameras
    # pictures take the place of the environment's state
    around = 0 if cameras else len(task.observation_names) - seen
    sizes = {"robot": seen, "environment": around, "pictures": len(cameras)}
    for part in POLICIES.find(policy).needs:
        if not sizes.get(part):
            where = f"{name} does not show it"
            if cameras and part == "environment":
                where = "pictures of observation.cameras are in its place"
            found = f"{describe(policy)}, which needs to see the {part}; {where}"
            yield Problem("training.policy", found, "another policy")
