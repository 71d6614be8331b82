"""Demonstrations on disk, and what policies are trained on for lerobot: LeRobot data sets.

lerobot writes them; reading takes the Parquet files they consist of, because importing lerobot
costs seconds that most stages do not have to spend.
"""

import contextlib
import logging
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from t2l.artefacts import read_arrow, read_json, reading, remove, whole
from t2l.demos.demonstration import Demonstration
from t2l.demos.episodes import NUMBER, by_episode
from t2l.errors import ArtefactError
from t2l.sim.batch import TIMESTEP_S
from t2l.tasks import Task

STATE, ENVIRONMENT, ACTION = "observation.state", "observation.environment_state", "action"
IMAGES = "observation.images."  # and the name of a camera


def write_demonstrations(demonstrations: Sequence[Demonstration], task: Task, path: Path) -> None:
    """Write demonstrations at the simulator's rate, in double precision.

    ``observation.state`` is q, dq and the positions of the grippers' joints;
    ``observation.environment_state`` the positions of all objects; ``action`` the torques and the
    gripper commands.
    """
    names = _demonstrated(task)
    features = {key: _feature("float64", own) for key, own in names.items()}
    episodes = (
        {
            STATE: np.concatenate(
                [d.qpos[:, task.arm_qpos], d.dq, d.qpos[:, task.gripper_qpos]], axis=1
            ),
            ENVIRONMENT: d.qpos[:, task.object_qpos],
            ACTION: np.concatenate([d.torque, d.gripper], axis=1),
        }
        for d in demonstrations
    )
    write_set(path, task, round(1 / TIMESTEP_S), features, episodes)


def read_demonstrations(path: Path | str, task: Task) -> list[Demonstration]:
    """Read what `write_demonstrations` wrote.

    Raises:
        ArtefactError: the folder is missing, cut short, or of another task or robot.
    """
    dof = len(task.robot.joints)
    demonstrations = []
    for episode in _read(Path(path), _demonstrated(task)):
        state = episode[STATE]
        qpos = np.empty((len(state), task.model.nq))
        qpos[:, task.arm_qpos] = state[:, :dof]
        qpos[:, task.gripper_qpos] = state[:, 2 * dof :]
        qpos[:, task.object_qpos] = episode[ENVIRONMENT]
        demonstrations.append(
            Demonstration(
                qpos=qpos,
                dq=state[:, dof : 2 * dof],
                torque=episode[ACTION][:, :dof],
                gripper=episode[ACTION][:, dof:],
            )
        )
    return demonstrations


def _demonstrated(task: Task) -> dict[str, list[str]]:
    """The features of demonstrations, by key: the names of their elements."""
    joints = task.robot.joints
    fingers = [joint for gripper in task.robot.grippers for joint in gripper.joints]
    return {
        STATE: [*_named("q", joints), *_named("dq", joints), *fingers],
        ENVIRONMENT: [f"qpos{i}" for i in task.object_qpos],
        ACTION: [*_named("tau", joints), *_grippers(task)],
    }


def write_dataset(
    episodes: Sequence[tuple[np.ndarray, np.ndarray]],
    task: Task,
    actions: Sequence[str],
    fps: int,
    path: Path,
    cameras: Sequence[str] = (),
    size_px: int = 0,
    pictures: Iterable[np.ndarray] = (),
) -> None:
    """Write what the policies of a cell are trained on, at the policy's rate: `policy_features`.

    Args:
        episodes: observation (n, nobs) and action (n, nact) of each, as `read_episodes` gives them.
        actions: names of an action's elements, without those of grippers.
        cameras, size_px: of pictures, if there are some.
        pictures: of each episode, (n, ncamera, size_px, size_px, 3) uint8.
    """
    own = task.robot_observation_size
    features = policy_features(task, actions, cameras, size_px)
    if cameras:
        around = (by_camera(cameras, seen) for seen in pictures)
    else:
        around = ({ENVIRONMENT: observation[:, own:]} for observation, _ in episodes)
    frames = (
        {STATE: observation[:, :own], ACTION: action, **rest}
        for (observation, action), rest in zip(episodes, around, strict=True)
    )
    write_set(path, task, fps, features, frames)


def by_camera(cameras: Sequence[str], pictures: np.ndarray) -> dict[str, np.ndarray]:
    """(n, size, size, 3) by feature, of pictures (n, ncamera, size, size, 3)."""
    return {IMAGES + name: pictures[:, i] for i, name in enumerate(cameras)}


def image_features(cameras: Sequence[str], size_px: int) -> dict[str, Any]:
    """Features of square pictures, a camera each."""
    shape = (size_px, size_px, 3)
    image = {"dtype": "image", "shape": shape, "names": ["height", "width", "channel"]}
    return {IMAGES + name: dict(image) for name in cameras}


def policy_features(
    task: Task, actions: Sequence[str], cameras: Sequence[str] = (), size_px: int = 0
) -> dict[str, dict[str, Any]]:
    """The features that a policy of lerobot learns from, as lerobot takes them, by key.

    The observation is split as lerobot's policies expect it: the robot's own state, and the state
    of its environment, whose place pictures take if there are some.

    Args:
        actions, cameras, size_px: as `write_dataset` takes them.
    """
    names, own = list(task.observation_names), task.robot_observation_size
    robot = {STATE: _feature("float32", names[:own])}
    action = {ACTION: _feature("float32", [*actions, *_grippers(task)])}
    if cameras:
        return robot | action | image_features(cameras, size_px)
    return robot | {ENVIRONMENT: _feature("float32", names[own:])} | action


def _grippers(task: Task) -> list[str]:
    return [f"gripper.{group.name}" for group in task.robot.groups if group.gripper]


def _named(quantity: str, joints: Sequence[str]) -> list[str]:
    return [f"{quantity}.{joint}" for joint in joints]


def _feature(dtype: str, names: list[str]) -> dict[str, Any]:
    return {"dtype": dtype, "shape": (len(names),), "names": names}


def write_set(
    path: Path,
    task: Task,
    fps: int,
    features: Mapping[str, Any],
    episodes: Iterable[Mapping[str, np.ndarray]],
) -> None:
    """Write a LeRobot data set whole.

    Args:
        features: as lerobot takes them, by name.
        episodes: of each episode the features' values, (n, …) each.
    """
    # nothing here is on the hub; without this lerobot asks it
    os.environ.setdefault("HF_HUB_OFFLINE", "1")
    logging.getLogger("lerobot").setLevel(logging.ERROR)
    import datasets
    from lerobot.datasets.lerobot_dataset import LeRobotDataset

    datasets.disable_progress_bars()
    images = any(feature["dtype"] == "image" for feature in features.values())
    with whole(path) as draft, contextlib.nullcontext() if images else _no_images():
        dataset = LeRobotDataset.create(
            repo_id=f"t2l/{task.name}",
            fps=fps,
            features=dict(features),
            root=draft,
            robot_type=task.robot.name,
            use_videos=False,
        )
        for episode in episodes:
            for frame in zip(*episode.values(), strict=True):
                dataset.add_frame(
                    {**dict(zip(episode, frame, strict=True)), "task": task.instruction}
                )
            dataset.save_episode()
        dataset.finalize()
        # where lerobot keeps images until they are in the tables
        remove(draft / "images")


@contextlib.contextmanager
def _no_images() -> Iterator[None]:
    """Spare lerobot from looking for images in each row, nine tenths of the time of writing.

    Upstream's limit: its writer (0.6) maps over all rows whether or not there are images, and has
    no switch for it.
    """
    from lerobot.datasets import dataset_writer

    embed = dataset_writer.embed_images
    dataset_writer.embed_images = lambda dataset: dataset
    try:
        yield
    finally:
        dataset_writer.embed_images = embed


def _read(path: Path, names: Mapping[str, Sequence[str]]) -> list[dict[str, np.ndarray]]:
    shapes = ", ".join(f"{key} ({len(own)},)" for key, own in names.items())
    expected = f"a LeRobot data set with {shapes}"
    try:
        return _episodes(path, names, expected)
    except ArtefactError as error:
        if error.path == path:
            raise
        # a data set is one artefact
        found = f"{error.path.relative_to(path)}: {error.found}"
        raise ArtefactError(path, found, error.expected) from None


def read_features(
    path: Path, shapes: Mapping[str, Sequence[int]], expected: str = ""
) -> tuple[list[Path], int]:
    """The tables of a LeRobot data set whose features have these shapes, and its number of frames.

    Raises:
        ArtefactError: the folder is missing or broken, or a feature is missing or of another shape.
    """
    expected = expected or f"a LeRobot data set with {', '.join(shapes)}"
    if not path.is_dir():
        found = "a file" if path.exists() else "no such folder"
        raise ArtefactError(path, found, expected)
    info_path = path / "meta" / "info.json"
    info = read_json(info_path, "what a data set holds", ("features", "total_frames"))
    with reading(info_path, "what a data set holds"):
        found = {key: info["features"][key]["shape"] for key in shapes}
    for key, shape in shapes.items():
        if found[key] != list(shape):
            raise ArtefactError(path, f"{key} has shape {found[key]}", expected)
    return sorted(path.glob("data/*/*.parquet")), info["total_frames"]


def _episodes(
    path: Path, names: Mapping[str, Sequence[str]], expected: str
) -> list[dict[str, np.ndarray]]:
    sizes = {key: len(own) for key, own in names.items()}
    files, total = read_features(path, {key: [size] for key, size in sizes.items()}, expected)
    _check_names(path, names)
    tables = [read_arrow(file, [*sizes, NUMBER]) for file in files]
    frames = sum(map(len, tables))
    if frames != total or frames == 0:
        raise ArtefactError(path, f"{frames} frames where info.json says {total}", expected)
    return by_episode(files, tables, sizes)


def _check_names(path: Path, names: Mapping[str, Sequence[str]]) -> None:
    """Tell robots of as many joints apart."""
    features = read_json(path / "meta" / "info.json", "what a data set holds")["features"]
    for key, wanted in names.items():
        found = features[key].get("names")
        if found != list(wanted):
            pairs = zip(found, wanted, strict=False) if isinstance(found, list) else ()
            one, other = next(((a, b) for a, b in pairs if a != b), (found, ", ".join(wanted)))
            raise ArtefactError(path, f"{key} holds {one}", f"{other}, as the task's robot has")
