"""Whether a policy, or the data set that it is trained on, has the features of the environment.

lerobot does not compare them. Without this a policy of another robot ends deep in a network, and
one that is asked at another rate fails at the task.
"""

from collections.abc import Mapping, Sequence

from lerobot.configs import PolicyFeature, PreTrainedConfig, parser
from lerobot.utils.feature_utils import dataset_to_policy_features

from t2l.demos.dataset import ACTION
from t2l.errors import InputError

# features by key, the names of their elements
Names = Mapping[str, Sequence[str]]


def check_policy(names: Names) -> None:
    """Compare the policy that lerobot's command line names, if any.

    Raises:
        InputError: it sees or does what the environment does not have.
    """
    path = parser.get_path_arg("policy")
    # other keys may then mean the same
    if path is None or parser.parse_arg("rename_map"):
        return
    policy = PreTrainedConfig.from_pretrained(path)
    _check(path, {**(policy.input_features or {}), **(policy.output_features or {})}, names)


def check_dataset(names: Names, fps: int) -> None:
    """Compare the data set that lerobot's command line names, if any.

    Raises:
        InputError: it has other features or another rate than the environment.
    """
    from lerobot.datasets.dataset_metadata import LeRobotDatasetMetadata

    repo_id, root = parser.parse_arg("dataset.repo_id"), parser.parse_arg("dataset.root")
    if repo_id is None:
        return
    dataset = LeRobotDatasetMetadata(repo_id, root=root)
    path = root or repo_id
    _check(path, dataset_to_policy_features(dataset.features), names)
    for key, here in names.items():
        there = dataset.features.get(key, {}).get("names")
        # data sets of others may have no names, or names by group
        pairs = zip(there, here, strict=False) if isinstance(there, list) else ()
        for i, (name, wanted) in enumerate(pairs):
            if name != wanted:
                raise InputError(path, f"{key}[{i}]", name, f"{wanted}, as in the environment")
    if dataset.fps != fps:
        raise InputError(path, "fps", str(dataset.fps), f"{fps}, as in the environment")


def _check(path: str, features: Mapping[str, PolicyFeature], names: Names) -> None:
    if ACTION not in features:
        raise InputError(path, ACTION, "nothing", f"({len(names[ACTION])},), as in the environment")
    for key, feature in features.items():
        if key not in names:
            allowed = f"{', '.join(names)}, the features of the environment"
            raise InputError(path, "features", key, allowed)
        shape, wanted = tuple(feature.shape), (len(names[key]),)
        if shape != wanted:
            raise InputError(path, key, f"shape {shape}", f"{wanted}, as in the environment")
