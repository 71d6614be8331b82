"""Observations and rewards in units of their spread, of many trainings side by side."""

from collections.abc import Mapping
from typing import Any

import torch
from torch import Tensor

from t2l.policies.gaussian_mlp import CLIPPED_AT
from t2l.rl.hyperparameters import GAMMA

# stable-baselines3's
EPSILON = 1e-8


class Normaliser:
    """Observations and rewards of each training, normalised as stable-baselines3's VecNormalize.

    Args:
        normalised: whether they are; else they stay as they are.
    """

    def __init__(
        self, n: int, observation_size: int, device: torch.device, normalised: bool = True
    ):
        self._normalised = normalised
        self.observation = Moments(n, observation_size, device)
        self._returned, self._discounted = Moments(n, 1, device), None

    def state(self) -> dict[str, Any]:
        """What was taken in, for `restore`."""
        kept = {name: vars(getattr(self, name)) for name in ("observation", "_returned")}
        return {**kept, "_discounted": self._discounted}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Go on from a `state`, whose tensors may be elsewhere."""
        device = self.observation.mean.device
        for name in ("observation", "_returned"):
            moments = getattr(self, name)
            moments.mean, moments.variance = (
                state[name][each].to(device) for each in ("mean", "variance")
            )
            moments.count = state[name]["count"]
        if state["_discounted"] is not None:
            self._discounted = state["_discounted"].to(device)

    def seen(self, observation: Tensor, learn: bool = True) -> Tensor:
        """Observations (n, m, nobs) normalised, taken in before if they are to be learned from."""
        if not self._normalised:
            return observation.float()
        if learn:
            self.observation.update(observation)
        mean, variance = self.observation.mean[:, None], self.observation.variance[:, None]
        normal = (observation - mean) / (variance + EPSILON).sqrt()
        return normal.clamp(-CLIPPED_AT, CLIPPED_AT).float()

    def paid(self, reward: Tensor, done: Tensor) -> Tensor:
        """Rewards (n, m) by the spread of discounted returns."""
        if not self._normalised:
            return reward.float()
        if self._discounted is None:
            self._discounted = torch.zeros_like(reward)
        self._discounted = self._discounted * GAMMA + reward
        self._returned.update(self._discounted[:, :, None])
        spread = (self._returned.variance + EPSILON).sqrt()
        self._discounted = torch.where(done, 0.0, self._discounted)
        return (reward / spread).clamp(-CLIPPED_AT, CLIPPED_AT).float()


class Moments:
    """Running mean and variance of each row's numbers, as stable-baselines3's RunningMeanStd.

    Attributes:
        mean, variance: (n, k) float64.
        count: how many numbers they are of.
    """

    def __init__(self, n: int, k: int, device: torch.device):
        self.mean = torch.zeros(n, k, dtype=torch.float64, device=device)
        self.variance, self.count = torch.ones_like(self.mean), 1e-4

    def update(self, values: Tensor) -> None:
        """Take in values (n, m, k)."""
        values, m = values.double(), values.shape[1]
        variance, mean = torch.var_mean(values, dim=1, correction=0)
        off, total = mean - self.mean, self.count + m
        spread = self.variance * self.count + variance * m + off**2 * self.count * m / total
        self.mean = self.mean + off * m / total
        self.variance, self.count = spread / total, total
