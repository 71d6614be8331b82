"""Whether a policy, or the data set that it is trained on, has the features of the environment.

lerobot does not compare them. Without this a policy of another robot ends deep in a network, and
one that is asked at another rate fails at the task.
"""

from collections.abc import Mapping
from typing import Any

from lerobot.configs import PolicyFeature, PreTrainedConfig, parser
from lerobot.utils.feature_utils import dataset_to_policy_features

from t2l.demos.dataset import ACTION
from t2l.errors import InputError

# as `t2l.demos.dataset.policy_features` has them, by key
Features = Mapping[str, Mapping[str, Any]]


def check_policy(held: Features) -> None:
    """Compare the policy that lerobot's command line names, if any.

    Args:
        held: what the environment has.

    Raises:
        InputError: it sees or does what the environment does not have.
    """
    path = parser.get_path_arg("policy")
    # other keys may then mean the same
    if path is None or parser.parse_arg("rename_map"):
        return
    policy = PreTrainedConfig.from_pretrained(path)
    _check(path, {**(policy.input_features or {}), **(policy.output_features or {})}, held)


def check_dataset(held: Features, fps: int) -> None:
    """Compare the data set that lerobot's command line names, if any.

    Args:
        held, fps: what the environment has.

    Raises:
        InputError: it has other features or another rate than the environment.
    """
    from lerobot.datasets.dataset_metadata import LeRobotDatasetMetadata

    repo_id, root = parser.parse_arg("dataset.repo_id"), parser.parse_arg("dataset.root")
    if repo_id is None:
        return
    dataset = LeRobotDatasetMetadata(repo_id, root=root)
    path = root or repo_id
    _check(path, dataset_to_policy_features(dataset.features), held)
    for key, feature in held.items():
        there = dataset.features.get(key, {}).get("names")
        # data sets of others may have no names, or names by group
        pairs = zip(there, feature["names"], strict=False) if isinstance(there, list) else ()
        for i, (name, wanted) in enumerate(pairs):
            if name != wanted:
                raise InputError(path, f"{key}[{i}]", name, f"{wanted}, as in the environment")
    if dataset.fps != fps:
        raise InputError(path, "fps", str(dataset.fps), f"{fps}, as in the environment")


def _check(path: str, features: Mapping[str, PolicyFeature], held: Features) -> None:
    allowed = {key: feature.shape for key, feature in dataset_to_policy_features(held).items()}
    if ACTION not in features:
        raise InputError(path, ACTION, "nothing", f"{allowed[ACTION]}, as in the environment")
    for key, feature in features.items():
        if key not in allowed:
            known = f"{', '.join(allowed)}, the features of the environment"
            raise InputError(path, "features", key, known)
        shape, wanted = tuple(feature.shape), tuple(allowed[key])
        if shape != wanted:
            raise InputError(path, key, f"shape {shape}", f"{wanted}, as in the environment")
