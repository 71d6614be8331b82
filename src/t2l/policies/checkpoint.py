"""Policies as files: safetensors, with the architecture in the header."""

import json
from pathlib import Path

from safetensors import SafetensorError, safe_open
from safetensors.torch import save_file

from t2l.artefacts import whole
from t2l.errors import ArtefactError
from t2l.policies.chunk_cvae import Architecture, ChunkCVAE

_KEY = "t2l_chunk_cvae"


def save(policy: ChunkCVAE, path: Path | str) -> None:
    """Write weights, normalisation and architecture whole."""
    tensors = {name: value.contiguous().cpu() for name, value in policy.state_dict().items()}
    with whole(path) as draft:
        save_file(tensors, draft, metadata={_KEY: json.dumps(policy.architecture.as_dict())})


def load(path: Path | str) -> ChunkCVAE:
    """Read a policy, on the CPU and ready to act.

    Raises:
        ArtefactError: the file is missing, cut short, or not a policy of t2l.
    """
    expected = "a policy that t2l saved (safetensors)"
    try:
        with safe_open(path, framework="pt") as file:
            metadata = file.metadata() or {}
            if _KEY not in metadata:
                raise ArtefactError(path, "holds no t2l policy", expected)
            fields = json.loads(metadata[_KEY])
            names = file.keys()
            tensors = {name: file.get_tensor(name) for name in names}
    except FileNotFoundError:
        raise ArtefactError(path, "no such file", expected) from None
    except SafetensorError as error:
        raise ArtefactError(path, f"cannot be read ({error})", expected) from None
    policy = ChunkCVAE(Architecture(**{**fields, "hidden": tuple(fields["hidden"])}))
    try:
        policy.load_state_dict(tensors)
    except RuntimeError as error:
        reason = str(error).splitlines()[-1].strip()
        raise ArtefactError(
            path, f"does not fit its own architecture ({reason})", expected
        ) from None
    return policy.eval()
