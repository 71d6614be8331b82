"""A training that is not finished, as a file, so that a killed one goes on to the same policy.

The file holds numbers, text and tensors alone: nothing runs that is read back.
"""

import logging
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Self

import numpy as np

from t2l.artefacts import remove, whole

log = logging.getLogger(__name__)


class Unfinished:
    """Where a training keeps its state.

    Args:
        of: all that the training depends on, as text; what was kept of another is not used.
    """

    def __init__(self, path: Path | str, of: str):
        self.path, self._of = Path(path), of

    @classmethod
    def together(cls, each: Sequence[Self]) -> Self:
        """Where trainings that go side by side keep their one state: that of the first."""
        return cls(each[0].path, "\n".join(one._of for one in each))

    def read(self) -> dict[str, Any] | None:
        """What was written last, arrays as tensors; nothing if there is nothing to go on from."""
        import torch

        if not self.path.is_file():
            return None
        try:
            kept = torch.load(self.path, map_location="cpu", weights_only=True)
            if kept["of"] == self._of:
                return kept["state"]
            found = "is of another training"
        except Exception as error:  # torch raises whatever a broken file makes it stumble over
            found = f"cannot be read ({error})"
        log.info("%s %s: it begins anew", self.path.name, found)
        return None

    def write(self, state: Mapping[str, Any]) -> None:
        """Keep a state: arrays, tensors, numbers and text in mappings and lists.

        Raises:
            OutputError: the system does not let it be written.
        """
        import torch

        with whole(self.path) as draft:
            torch.save({"of": self._of, "state": _plain(state)}, draft)

    def remove(self) -> None:
        """Let go what was kept, once the training's results are written."""
        remove(self.path)


def _plain(value: Any) -> Any:
    import torch

    if isinstance(value, np.ndarray):
        return torch.from_numpy(value)
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, Mapping):
        return {key: _plain(own) for key, own in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(own) for own in value]
    return value
