"""A learning rate that keeps policies near the one that acted, as in the study's PPO.

Schulman et al. (2017), section 4, adapt a penalty by the KL divergence; here it is the rate, once
an epoch, by the rule and with the bounds of skrl's KLAdaptiveLR, which the study uses.
"""

from collections.abc import Mapping
from typing import Any

import torch
from stable_baselines3 import PPO
from stable_baselines3.common.buffers import RolloutBuffer
from stable_baselines3.common.policies import ActorCriticPolicy

BOUNDS = (1e-6, 1e-2)
FACTOR = 1.5


def divergence(log_ratio: torch.Tensor) -> torch.Tensor:
    """KL divergence from the policy that acted, by the estimator r − 1 − ln r; their mean."""
    return (torch.expm1(log_ratio) - log_ratio).mean()


def adapted(rate: torch.Tensor, kl: torch.Tensor, target_kl: float) -> torch.Tensor:
    """Learning rates after an epoch with these divergences, element by element."""
    slower, faster = kl > 2 * target_kl, (kl > 0) & (kl < target_kl / 2)
    rate = torch.where(slower, rate / FACTOR, rate)
    return torch.where(faster, rate * FACTOR, rate).clamp(*BOUNDS)


class RememberingBuffer(RolloutBuffer):
    """A rollout buffer that keeps the minibatch it gave last as `minibatch`."""

    def _get_samples(self, batch_inds, env=None):
        self.minibatch = super()._get_samples(batch_inds, env)
        return self.minibatch


class WatchedPolicy(ActorCriticPolicy):
    """A policy that shows the log-probabilities of each minibatch to `watch`."""

    watch = None

    def evaluate_actions(self, obs, actions):
        """See `ActorCriticPolicy`."""
        values, log_prob, entropy = super().evaluate_actions(obs, actions)
        if self.watch is not None:
            self.watch(log_prob.detach())
        return values, log_prob, entropy


class AdaptiveRate:
    """The learning rate of a PPO with a `WatchedPolicy` and a `RememberingBuffer`.

    After each epoch it falls where the KL divergence from the policy that acted, the mean over the
    epoch's minibatches, is above twice the target, and rises where it is below half of it.

    Attributes:
        rate: the current one.
        kl: `divergence` in the last whole epoch.
    """

    def __init__(self, ppo: PPO, rate: float, target_kl: float, minibatches: int):
        """Begin.

        Args:
            minibatches: of an epoch.
        """
        self.rate, self.kl, self._target_kl = rate, 0.0, target_kl
        self._ppo, self._minibatches, self._found = ppo, minibatches, []
        ppo.lr_schedule = lambda _: self.rate
        ppo.policy.watch = self._watch

    def state(self) -> dict[str, Any]:
        """What later rates depend on, for `restore`."""
        return {"rate": self.rate, "kl": self.kl, "found": self._found}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Go on from a `state`."""
        self.rate, self.kl, self._found = state["rate"], state["kl"], list(state["found"])

    def _watch(self, log_prob: torch.Tensor) -> None:
        if len(self._found) == self._minibatches:
            self.adapt(sum(self._found) / self._minibatches)
            self._found.clear()
        log_ratio = log_prob - self._ppo.rollout_buffer.minibatch.old_log_prob
        self._found.append(float(divergence(log_ratio)))

    def adapt(self, kl: float) -> None:
        """Take in the divergence of an epoch."""
        self.kl = kl
        both = torch.tensor([self.rate, kl], dtype=torch.float64)
        self.rate = float(adapted(*both, self._target_kl))
        for group in self._ppo.policy.optimizer.param_groups:
            group["lr"] = self.rate
