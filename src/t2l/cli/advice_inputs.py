"""What `t2l advise` is asked about: the robot, what is known of its machine, what it is to do."""

import argparse
import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from t2l.advise.advice import Asked
    from t2l.advise.shown import Shown
    from t2l.demos.demonstration import Demonstration
    from t2l.identify.model import Model
    from t2l.recordings.recording import Recording
    from t2l.tasks import Demonstrated

STILL_RAD = 1e-3  # bound: of motions; a joint that moves less says nothing of itself
FIRST = 4  # numerics: demonstrations, by whose attempts a task that cannot be done is found
ATTEMPTS = 4  # numerics: for each demonstration, at most
RATE_HZ = 1000.0  # convention: of a loop of which nothing is said, that of an FR3


@dataclass(frozen=True)
class Body:
    """A robot as the command names it.

    Attributes:
        units: (n, 2) what gains of a cell are factors on.
        ranges: (n, 2) rad; velocity, torque: (n,) limits; infinite where unknown.
        home: (n,) rad.
    """

    robot: str
    joints: tuple[str, ...]
    units: np.ndarray
    ranges: np.ndarray
    velocity: np.ndarray
    torque: np.ndarray
    home: np.ndarray


def body_of(arguments: argparse.Namespace) -> Body:
    """What is known of the robot before anything else is."""
    from t2l.errors import ConfigurationError
    from t2l.robots import ROBOTS, make_robot, plant
    from t2l.robots.from_file import home_of
    from t2l.sim.loop import torque_limits

    if arguments.robot in ROBOTS.names():
        robot = make_robot(arguments.robot)
        body = Body(
            robot.name, robot.joints, np.stack(robot.gains(1.0, 1.0), axis=1),
            robot.position_limit, robot.velocity_limit, robot.torque_limit, robot.home,
        )  # fmt: skip
        wanted = tuple(arguments.joints or body.joints)
        if unknown := [name for name in wanted if name not in body.joints]:
            raise ConfigurationError(
                f"--joints: found {unknown[0]!r}; allowed: {', '.join(body.joints)}"
            )
        at = [body.joints.index(name) for name in wanted]
        return Body(
            body.robot, wanted, body.units[at], body.ranges[at], body.velocity[at],
            body.torque[at], body.home[at],
        )  # fmt: skip
    path = plant.mjcf_path(arguments.robot).resolve()
    joints = tuple(arguments.joints or (joint.name for joint in plant.scalar_joints(str(path))))
    if not joints:
        raise ConfigurationError(f"{path}: found no hinge or slide joint; allowed: one or more")
    model = plant.compiled(plant.load(str(path), joints), str(path))
    n = len(joints)
    return Body(
        str(path), joints, np.ones((n, 2)), plant.position_ranges(model, joints),
        np.full(n, np.inf), abs(torque_limits(model, joints)).min(axis=1),
        home_of(path, model, joints),
    )  # fmt: skip


def machine_of(arguments: argparse.Namespace, body: Body) -> tuple["Model", "list[Recording]"]:
    """The model so far, and the recordings if there are some, checked."""
    from t2l.diagnose.recordings_and_model import check_worth_fitting, read_recordings_and_model
    from t2l.errors import ConfigurationError
    from t2l.identify.model import Model, check_joints, read_model
    from t2l.registry import python_files

    own = tuple(path.resolve() for path in arguments.effects)
    if not arguments.logs:
        if arguments.model is None:
            return Model(body.robot, {}, own), []
        model = read_model(arguments.model, trusted=python_files(own))
        _check_alike(f"{arguments.model}: robot", model.robot, body)
        check_joints(arguments.model, model, body.joints)
        return model, []
    model, recordings, _ = read_recordings_and_model(
        arguments.logs, (), arguments.model, arguments.effects
    )
    first = recordings[0]
    _check_alike("--logs", first.robot, body)
    if set(first.joints) != set(body.joints):
        raise ConfigurationError(
            f"--logs: found joints {', '.join(first.joints)}; allowed: {', '.join(body.joints)}, "
            "or --joints with those of the recordings"
        )
    if arguments.model is None:
        _check_excited(recordings)
        check_worth_fitting(model, recordings)
    return model, recordings


def _check_alike(what: str, robot: str, body: Body) -> None:
    """Whether effects of another robot may be taken for this one: its joints have the same names.

    Raises:
        ConfigurationError: they have not.
    """
    from t2l.errors import ConfigurationError
    from t2l.robots.plant import mjcf_path, scalar_joints

    if mjcf_path(robot).resolve() == mjcf_path(body.robot).resolve():
        return
    names = {joint.name for joint in scalar_joints(robot)}
    if missing := [name for name in body.joints if name not in names]:
        raise ConfigurationError(
            f"{what}: found {robot}, which has no joint {missing[0]}; allowed: {body.robot}, of "
            "ROBOT, or a robot with its joints, such as the same arm without a hand"
        )


def _check_excited(recordings: "list[Recording]") -> None:
    """Find a joint of which the recordings say nothing.

    Raises:
        RecordingError: such a joint, with what to record.
    """
    from t2l.errors import RecordingError

    for j, joint in enumerate(recordings[0].joints):
        moves = max(float(np.nanmax(r.q[:, j]) - np.nanmin(r.q[:, j])) for r in recordings)
        if moves < STILL_RAD:
            first = recordings[0]
            raise RecordingError(
                first.path or first.name, f"joint {joint}",
                f"no motion above {1e3 * STILL_RAD:g} mrad in any recording",
                "recordings in which each joint moves: t2l plan chooses motions that tell its "
                "effects apart, t2l record makes them; or --model with what is known of it",
            )  # fmt: skip


def shown_of(
    arguments: argparse.Namespace,
    body: Body,
    recordings: "list[Recording]",
    by_expert: "tuple[Demonstrated, list[Demonstration]] | None",
) -> "Shown | None":
    """What the robot is to do."""
    from t2l.advise.shown import of_dataset, of_task
    from t2l.cli.inputs import gain_of_each
    from t2l.demos.other_gains import Gains
    from t2l.identify.prediction import with_effects

    if by_expert is not None:
        return of_task(*by_expert)
    if not arguments.demonstrations:
        return None
    gains = None
    if arguments.recorded_kp is not None:
        gains = Gains(
            gain_of_each(arguments, "recorded_kp", body.joints, zero=False),
            gain_of_each(arguments, "recorded_kd", body.joints),
        )
    return of_dataset(
        arguments.demonstrations, with_effects(body.robot, body.joints), body.joints, body.ranges,
        gains, not compensated(arguments, recordings), arguments.degrees,
    )  # fmt: skip


def by_expert(
    arguments: argparse.Namespace, body: Body
) -> "tuple[Demonstrated, list[Demonstration]] | None":
    """A task and demonstrations of its expert, None without --task.

    Raises:
        ConfigurationError: nobody can show the task, or the robot cannot do it.
    """
    from t2l.config.tasks import read_task_file
    from t2l.demos.expert import demonstrate
    from t2l.errors import ConfigurationError, ExpertError
    from t2l.tasks import Demonstrated, make_task

    if not arguments.task:
        return None
    task = make_task(read_task_file(Path(arguments.task), robot=body.robot))
    if not isinstance(task, Demonstrated):
        raise ConfigurationError(
            f"{arguments.task}: found a task without an expert; allowed: one with, such as "
            "block_stack, or --demonstrations"
        )
    if task.robot.joints != body.joints:
        raise ConfigurationError(
            f"--joints: found {', '.join(body.joints)}; allowed with --task: all of "
            f"{', '.join(task.robot.joints)}"
        )
    rng = np.random.default_rng(0)
    try:
        shown = demonstrate(task, FIRST, ATTEMPTS * FIRST, rng, cores())
        if arguments.count > FIRST:
            more = arguments.count - FIRST
            shown += demonstrate(task, more, ATTEMPTS * more, rng, cores())
    except ExpertError as error:
        raise ConfigurationError(
            f"{arguments.task}: found a task that {body.robot} does not reach: {error}; allowed: "
            "a task within its workspace, or fewer demonstrations by --count"
        ) from None
    return task, shown


def compensated(arguments: argparse.Namespace, recordings: "list[Recording]") -> bool:
    """Whether the controller carries the weight."""
    if recordings:
        return bool(recordings[0].gravity_compensation)
    return not arguments.no_gravity_compensation


def asked_of(
    arguments: argparse.Namespace,
    body: Body,
    model: "Model",
    recordings: "list[Recording]",
    shown: "Shown | None",
) -> "Asked":
    """The question, with the grid that it is about."""
    from t2l.advise import grid
    from t2l.advise.advice import POSES, Asked

    poses = _poses(body, POSES) if shown is None else shown.poses(POSES)
    common = dict(
        model=model, joints=body.joints, poses=poses, units=body.units,
        control_rate_hz=control_rate_hz(arguments, recordings),
        policy_rate_hz=arguments.policy_rate, compensated=compensated(arguments, recordings),
        ranges=body.ranges, velocity_limit=body.velocity, torque_limit=body.torque, shown=shown,
        most_sag_rad=arguments.most_sag, threads=cores(),
    )  # fmt: skip
    kp, kd = listed(arguments.kp), listed(arguments.kd)
    if kp is not None and kd is not None:
        return Asked(grid=grid.of(kp, kd), **common)
    first = Asked(grid=grid.grid_of_factors(), **common)
    if (body.units != 1).any():
        return first
    return Asked(grid=grid.default_grid(first.machine().inertia), **common)


def _poses(body: Body, count: int) -> np.ndarray:
    """(count, n) rad: home, and others about it within the joints' ranges."""
    low, high = np.clip(body.ranges, -np.pi, np.pi).T
    drawn = np.random.default_rng(0).uniform(0.25, 0.75, (count - 1, len(low)))
    return np.concatenate([body.home[None], low + drawn * (high - low)])


def listed(values: float | list[float] | None) -> list[float] | None:
    """Different numbers of an option, ascending."""
    if values is None:
        return None
    return sorted({*values} if isinstance(values, list) else {values})


def control_rate_hz(arguments: argparse.Namespace, recordings: "list[Recording]") -> float:
    """Of the robot's loop."""
    if arguments.control_rate is not None:
        return arguments.control_rate
    return recordings[0].control_rate_hz if recordings else RATE_HZ


def cores() -> int:
    """That may be used."""
    return len(os.sched_getaffinity(0))
