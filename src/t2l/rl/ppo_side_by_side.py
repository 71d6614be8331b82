"""PPO of many policies side by side: in step, each with its own robots, weights and learning rate.

What a policy learns from, its network and its objective are those of `t2l.rl.ppo`; only the loop
is another one than stable-baselines3's, in which one step of the GPU moves all policies. Policies
do not touch each other. What noise a policy meets depends on who trains beside it.
"""

import logging
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from torch import Tensor

from t2l.environment.environment import Environment
from t2l.policies.captured import Captured
from t2l.policies.gaussian_mlp import GaussianMLP
from t2l.rl.adaptive_rate import adapted, divergence
from t2l.rl.algorithm import Report, Trained, TrainingEnded, TrainingError
from t2l.rl.evaluate import evaluate_side_by_side
from t2l.rl.hyperparameters import CLIP, EPOCHS, GAMMA, GRADIENT_NORM, LAMBDA, of_task
from t2l.rl.normaliser import EPSILON, Normaliser
from t2l.rl.ppo import ActorCritic, layers_of, make_policy
from t2l.rl.progress import Progress
from t2l.rl.settings import Settings
from t2l.rl.stacked import Adam, Stack
from t2l.rl.unfinished import Unfinished

log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class Rollout:
    """What n policies are updated with; m samples of each, k numbers a sample.

    Attributes:
        observation: (n, m, nobs) normalised.
        action: (n, m, naction) before they were clipped.
        log_prob, value, advantage, returns: (n, m).
    """

    observation: Tensor
    action: Tensor
    log_prob: Tensor
    value: Tensor
    advantage: Tensor
    returns: Tensor

    def minibatch(self, ids: Tensor) -> tuple[Tensor, ...]:
        """Samples `ids` of every policy."""
        return tuple(getattr(self, name)[:, ids] for name in self.__dataclass_fields__)


class SideBySide:
    """Policies that learn in the robots of one world, as many trainings as it has generators.

    Attributes:
        stack: their networks.
        rate: (n,) learning rates.
    """

    def __init__(self, world: Environment, seeds: Sequence[int], shared: bool):
        """Begin; `shared` as of `t2l.rl.ppo.make_policy`."""
        self.world, self.n = world, len(seeds)
        states = world.simulator.q
        self._numpy = isinstance(states, np.ndarray)
        self.device = device = torch.device("cpu") if self._numpy else states.device
        size, actions = world.observation_size, len(world.action_names)
        self.column = of_task(world.task)
        self._policies = [
            make_policy(size, actions, world.bound, seed, shared, self.column) for seed in seeds
        ]
        self.stack = Stack([ActorCritic(policy) for policy in self._policies], device)
        self.normaliser = Normaliser(self.n, size, device, self.column.normalised)
        self.rate = torch.full((self.n,), self.column.learning_rate, device=device)
        self._adam = Adam(self.stack.rows)
        self._gradient = Captured(self._gradients)
        self._generator = torch.Generator(device).manual_seed(seeds[0])
        torch.manual_seed(seeds[0])
        self._seen = self.normaliser.seen(self._split(world.begin()))
        self._none = self._mask(np.arange(0))

    def update(self) -> Tensor:
        """Act, and learn from it; (n,) mean reward of a step."""
        rollout, reward = self._act()
        self.learn(rollout, self._orders(rollout.value.shape[1]))
        return reward

    @torch.no_grad()
    def _act(self) -> tuple[Rollout, Tensor]:
        steps, paid, ends = [], [], []
        reward = torch.zeros(self.n, device=self.device)
        for _ in range(self.column.rollout_steps):
            mean, log_std, value = self.stack(self._seen)
            noise = torch.randn(mean.shape, generator=self._generator, device=self.device)
            action = mean + log_std.exp() * noise
            log_prob = log_probability(action, mean, log_std)
            steps.append((self._seen, action, log_prob, value))
            observation, got, ended = self.world.advance(self._merged(action))
            got = self._split(got)
            reward += got.mean(dim=1) / self.column.rollout_steps
            done = self._mask(ended.ids) if len(ended.ids) else self._none
            self._seen = self.normaliser.seen(self._split(observation))
            got = self.normaliser.paid(got, done)
            if len(ended.ids):
                # what would have come after an episode that only its length ended
                last = torch.zeros_like(self._seen)
                last[done] = self._tensor(ended.observation)
                after = self.stack(self.normaliser.seen(last, learn=False))[2]
                by_length = self._mask(ended.ids[~ended.failed])
                got = got + GAMMA * torch.where(by_length, after, 0.0)
            paid.append(got)
            ends.append(done)
        after = self.stack(self._seen)[2]
        parts = [torch.stack(part, dim=1) for part in zip(*steps, strict=True)]
        advantage = advantages(torch.stack(paid, dim=1), parts[3], after, torch.stack(ends, dim=1))
        every = [*parts, advantage, advantage + parts[3]]
        return Rollout(*(part.flatten(1, 2) for part in every)), reward

    def learn(self, rollout: Rollout, orders: Sequence[Tensor]) -> None:
        """Update the policies.

        Args:
            orders: of the samples, (m,) for each epoch.
        """
        for order in orders:
            kl = []
            for ids in order.chunk(self.column.minibatches):
                gradient, apart = self._gradient(*rollout.minibatch(ids))
                self._adam.step(gradient, self.rate)
                kl.append(apart.clone())
            self.rate = adapted(self.rate, torch.stack(kl).mean(dim=0), self.column.target_kl)

    def _gradients(self, *minibatch: Tensor) -> tuple[Tensor, Tensor]:
        """Of each policy's loss, its norm bounded; and how far the policy is from what acted."""
        loss, apart = torch.vmap(self._loss)(self.stack.rows, *minibatch)
        (gradient,) = torch.autograd.grad(loss.sum(), self.stack.rows)
        norm = gradient.norm(dim=1, keepdim=True)
        # torch's `clip_grad_norm_`
        return gradient * (GRADIENT_NORM / (norm + 1e-6)).clamp(max=1.0), apart.detach()

    def _loss(self, row, observation, action, log_prob, value, advantage, returns):
        """PPO's objective of one policy, and its KL divergence from the policy that acted."""
        mean, log_std, found = self.stack.of_row(row, observation)
        log_ratio = log_probability(action, mean, log_std) - log_prob
        ratio = log_ratio.exp()
        advantage = (advantage - advantage.mean()) / (advantage.std() + EPSILON)
        gain = torch.minimum(advantage * ratio, advantage * ratio.clamp(1 - CLIP, 1 + CLIP))
        within = value + (found - value).clamp(-CLIP, CLIP)
        entropy = (log_std + 0.5 * np.log(2 * np.pi * np.e)).sum(dim=-1)
        value_loss = ((returns - within) ** 2).mean()
        loss = -gain.mean() - self.column.entropy * entropy.mean()
        loss = loss + self.column.value * value_loss
        return loss, divergence(log_ratio)

    def state(self) -> dict[str, Any]:
        """All that further updates depend on, for `restore`."""
        cuda = self.device.type == "cuda"
        return {
            "networks": self._adam.state(),
            "normaliser": self.normaliser.state(),
            "rate": self.rate,
            "seen": self._seen,
            "world": self.world.state(),
            "generator": self._generator.get_state(),
            "torch": torch.cuda.get_rng_state(self.device) if cuda else torch.get_rng_state(),
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        """Go on from a `state` of trainings that began alike."""
        self._adam.restore(state["networks"])
        self.normaliser.restore(state["normaliser"])
        self.rate, self._seen = (state[name].to(self.device) for name in ("rate", "seen"))
        self.world.restore(state["world"])
        self._generator.set_state(state["generator"])
        if self.device.type == "cuda":
            torch.cuda.set_rng_state(state["torch"], self.device)
        else:
            torch.set_rng_state(state["torch"])

    def finite(self) -> np.ndarray:
        """(n,) bool: whose parameters are finite."""
        return torch.isfinite(self.stack.rows).all(dim=1).cpu().numpy()

    def export(self) -> list[GaussianMLP]:
        """The policies as they are, which act by their means."""
        mean = self.normaliser.observation.mean.cpu().numpy()
        deviation = (self.normaliser.observation.variance + EPSILON).sqrt().cpu().numpy()
        scale = self.world.action_scale[:: self.world.each]
        made = []
        for i, row in enumerate(self.stack.rows.detach().cpu()):
            weights, biases = layers_of(self._policies[0], _of_policy(self.stack.named(row)))
            made.append(
                GaussianMLP(
                    mean[i], deviation[i], weights, biases, scale[i], clipped=self.world.bound <= 1
                )
            )
        return made

    def _orders(self, m: int) -> list[Tensor]:
        drawn = {"generator": self._generator, "device": self.device}
        return [torch.randperm(m, **drawn) for _ in range(EPOCHS)]

    def _mask(self, ids: np.ndarray) -> Tensor:
        mask = np.zeros(self.world.rows, bool)
        mask[ids] = True
        return torch.as_tensor(mask, device=self.device).view(self.n, -1)

    def _tensor(self, values) -> Tensor:
        return torch.as_tensor(values, dtype=torch.float32, device=self.device)

    def _split(self, values) -> Tensor:
        """(rows, …) of the world as (n, each, …)."""
        return self._tensor(values).unflatten(0, (self.n, self.world.each))

    def _merged(self, values: Tensor):
        """(n, each, …) as arrays of the world."""
        flat = values.flatten(0, 1)
        return flat.numpy() if self._numpy else flat


def _of_policy(parameters: Mapping[str, Tensor]) -> dict[str, Tensor]:
    """Without the name that `ActorCritic` puts before."""
    return {name.removeprefix("policy."): value for name, value in parameters.items()}


def log_probability(action: Tensor, mean: Tensor, log_std: Tensor) -> Tensor:
    """Of actions (…, k) under a normal distribution of each element."""
    off = (action - mean) / log_std.exp()
    return (-0.5 * off**2 - log_std - 0.5 * np.log(2 * np.pi)).sum(dim=-1)


def advantages(reward: Tensor, value: Tensor, after: Tensor, done: Tensor) -> Tensor:
    """Generalised advantage estimates (Schulman et al. 2016, eq. 16), (n, nstep, m).

    Args:
        reward, value, done: (n, nstep, m), value before each step.
        after: (n, m) value after the last.
    """
    found, following, ahead = torch.empty_like(reward), after, torch.zeros_like(after)
    for t in reversed(range(reward.shape[1])):
        goes_on = ~done[:, t]
        error = reward[:, t] + GAMMA * following * goes_on - value[:, t]
        ahead = error + GAMMA * LAMBDA * goes_on * ahead
        found[:, t], following = ahead, value[:, t]
    return found


def train_side_by_side(
    world: Environment,
    judges: Environment,
    seeds: Sequence[int],
    settings: Settings,
    reports: Sequence[Report],
    unfinished: Unfinished | None = None,
) -> list[Trained | TrainingError | TrainingEnded]:
    """See `Algorithm.train_side_by_side`.

    Args:
        unfinished: where their state is kept after each evaluation, while none has ended.
    """
    learning = SideBySide(world, seeds, settings.shared_network)
    progress = [Progress(settings, report) for report in reports]
    ended: dict[int, TrainingError | TrainingEnded] = {}
    rewards, began, done = [], time.monotonic(), 0
    if kept := unfinished.read() if unfinished else None:
        learning.restore(kept["learning"])
        judges.restore(kept["judges"])
        for own, state in zip(progress, kept["progress"], strict=True):
            own.restore(state)
        done = kept["updates"]
        log.info("goes on after update %d", done)
    for update in range(1 + done, settings.updates + 1):
        rewards.append(learning.update())
        for i in np.flatnonzero(~learning.finite()):
            ended.setdefault(int(i), TrainingError.not_finite(update))
        if update % settings.evaluate_every and update < settings.updates:
            continue
        policies = learning.export()
        found = evaluate_side_by_side(policies, judges)
        log.info(
            "update %d of %d: success %.2f, mean of %d trainings; %.0f s left",
            *(update, settings.updates, np.mean([own.success for own in found]), len(found)),
            (time.monotonic() - began) / (update - done) * (settings.updates - update),
        )
        reward, paid = torch.stack(rewards).mean(dim=0) / world.period_s, world.paid()
        rewards.clear()
        for i, own in enumerate(progress):
            if i in ended or own.enough:
                continue
            try:
                own.take(
                    policies[i], found[i], update=update,
                    steps=update * learning.column.rollout_steps * world.each,
                    reward=float(reward[i]),
                    terms={name: float(value[i]) for name, value in paid.items()},
                    learning_rate=float(learning.rate[i]),
                )  # fmt: skip
            except TrainingEnded as reason:
                ended[i] = reason
        if all(i in ended or own.enough for i, own in enumerate(progress)):
            break
        if unfinished and not ended:
            unfinished.write(
                {
                    "learning": learning.state(),
                    "judges": judges.state(),
                    "progress": [own.state() for own in progress],
                    "updates": update,
                }
            )
    return [ended.get(i) or own.trained() for i, own in enumerate(progress)]
