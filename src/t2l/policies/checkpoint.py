"""Policies as files: safetensors, with the architecture in the header."""

import json
from dataclasses import fields
from pathlib import Path
from typing import Any

import torch
from safetensors import safe_open
from safetensors.torch import save as serialise

from t2l.artefacts import checked_file, parsing, reading, whole
from t2l.errors import ArtefactError
from t2l.policies.chunk_cvae import Architecture, ChunkCVAE
from t2l.typed import describe

_KEY = "t2l_chunk_cvae"


def save(policy: ChunkCVAE, path: Path | str) -> None:
    """Write weights, normalisation and architecture whole."""
    tensors = {name: value.contiguous().cpu() for name, value in policy.state_dict().items()}
    content = serialise(tensors, metadata={_KEY: json.dumps(policy.architecture.as_dict())})
    with whole(path) as draft:
        # not safetensors' own file, whose errors do not say what the system said
        draft.write_bytes(content)


def load(path: Path | str) -> ChunkCVAE:
    """Read a policy, on the CPU and ready to act.

    Raises:
        ArtefactError: the file is missing, cut short, or not a policy of t2l.
    """
    expected = "a policy that t2l saved (safetensors)"
    path = checked_file(path, expected)
    with parsing(path, expected), safe_open(path, framework="pt") as file:
        metadata = file.metadata() or {}
        names = file.keys()
        tensors = {name: file.get_tensor(name) for name in names}
    if _KEY not in metadata:
        raise ArtefactError(path, "holds no t2l policy", expected)
    with reading(path, expected):
        architecture = _architecture(json.loads(metadata[_KEY]))
        # without memory, however large it says it is
        with torch.device("meta"):
            policy = ChunkCVAE(architecture)
        for name, tensor in policy.state_dict().items():
            found = tensors[name]
            if (found.shape, found.dtype) != (tensor.shape, tensor.dtype):
                raise ValueError(f"{name} is {found.dtype} of {tuple(found.shape)}, "
                                 f"not {tensor.dtype} of {tuple(tensor.shape)}")  # fmt: skip
        if set(tensors) != set(policy.state_dict()):
            raise ValueError("tensors that its architecture does not have")
    policy.load_state_dict(tensors, assign=True)
    return policy.eval()


def _architecture(content: Any) -> Architecture:
    """The architecture that metadata describe."""
    names = {field.name for field in fields(Architecture)}
    if not isinstance(content, dict) or set(content) != names:
        raise ValueError(f"an architecture of other keys than {', '.join(sorted(names))}")
    found = Architecture(**{**content, "hidden": tuple(content["hidden"])})
    for size in (*found.hidden, *(getattr(found, name) for name in names - {"hidden"})):
        if type(size) is not int or not 0 < size < 2**31:
            raise ValueError(f"found {describe(size)} as a size in the architecture")
    return found
