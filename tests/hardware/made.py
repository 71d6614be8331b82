"""What it takes to deploy without having learned anything."""

import numpy as np

from t2l.policies import Policy


class Proportional(Policy):
    """Moves every joint by `gain` times what is left to do."""

    name = "proportional"
    history = chunk = 1

    def __init__(self, njoint: int, gain: float = 3.0):
        self.observation_size, self.action_size, self.gain = 4 * njoint, njoint, gain

    def act(self, history: np.ndarray) -> np.ndarray:
        left = history[:, -1:, 2 * self.action_size : 3 * self.action_size]
        return np.clip(self.gain * left, -1, 1)

    def tensors(self):
        return {"gain": np.array(self.gain)}

    def metadata(self):
        return {"action_size": self.action_size}

    @classmethod
    def restored(cls, tensors, metadata):
        return cls(metadata["action_size"], float(tensors["gain"]))
