"""Policies as files: safetensors, whose header names the policy and tells what is no tensor."""

import json
from pathlib import Path

import numpy as np
from safetensors import safe_open
from safetensors.numpy import save as serialise

from t2l.artefacts import checked_file, parsing, reading, whole
from t2l.errors import ArtefactError
from t2l.policies.policy import Policy
from t2l.policies.registry import POLICIES

# of the header, the only one: safetensors writes several in any order
_KEY = "t2l_policy"

_EXPECTED = "a policy that t2l saved (safetensors)"


def save(policy: Policy, path: Path | str) -> None:
    """Write a policy whole."""
    header = {_KEY: json.dumps({"name": policy.name, "metadata": policy.metadata()})}
    tensors = {name: np.ascontiguousarray(array) for name, array in policy.tensors().items()}
    content = serialise(tensors, metadata=header)
    with whole(path) as draft:
        # not safetensors' own file, whose errors do not say what the system said
        draft.write_bytes(content)


def load(path: Path | str) -> Policy:
    """Read a policy, ready to act.

    Raises:
        ArtefactError: the file is missing, cut short, no policy of t2l, or one whose class is not
            known here.
    """
    path = checked_file(path, _EXPECTED)
    with parsing(path, _EXPECTED), safe_open(path, framework="numpy") as file:
        header = file.metadata() or {}
        tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
    if _KEY not in header:
        raise ArtefactError(path, "holds no t2l policy", _EXPECTED)
    with reading(path, _EXPECTED):
        content = json.loads(header[_KEY])
        return POLICIES.find(content["name"]).restored(tensors, content["metadata"])
