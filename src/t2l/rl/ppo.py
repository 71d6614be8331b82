"""PPO (Schulman et al. 2017) of stable-baselines3 with the study's hyper-parameters."""

import logging
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import torch
from gymnasium import spaces
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import Logger
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
from stable_baselines3.common.vec_env import VecEnv, VecNormalize
from torch.distributions import Normal

from t2l.policies.gaussian_mlp import CLIPPED_AT, GaussianMLP
from t2l.rl import ppo_state
from t2l.rl.adaptive_rate import AdaptiveRate, RememberingBuffer, WatchedPolicy
from t2l.rl.algorithm import Algorithm, Report, Trained, TrainingError
from t2l.rl.environments import Environments
from t2l.rl.evaluate import evaluate
from t2l.rl.hyperparameters import (
    CLIP,
    EPOCHS,
    GAMMA,
    GRADIENT_NORM,
    LAMBDA,
    REACH,
    Hyperparameters,
    of_task,
)
from t2l.rl.progress import Progress
from t2l.rl.settings import Settings
from t2l.rl.unfinished import Unfinished

log = logging.getLogger(__name__)


class ProximalPolicyOptimisation(Algorithm):
    """Hidden layers of ELU units, which policy and value share or have each for itself."""

    name = "ppo"
    side_by_side = True
    resumes = True

    def train_side_by_side(self, world, judges, seeds, settings, reports, unfinished=None):
        """See `Algorithm.train_side_by_side`."""
        from t2l.rl.ppo_side_by_side import train_side_by_side

        return train_side_by_side(world, judges, seeds, settings, reports, unfinished)

    def train(
        self,
        environments: Environments,
        judges: Environments,
        settings: Settings,
        report: Report = lambda update, policy, evaluation: None,
        threads: int = 1,
        unfinished: Unfinished | None = None,
    ) -> Trained:
        """See `Algorithm.train`.

        Args:
            unfinished: where its state is kept after each evaluation.
        """
        column = of_task(environments.task)
        model = make_model(environments, settings.seed, settings.shared_network, column)
        listener = _Listener(
            AdaptiveRate(model, column.learning_rate, column.target_kl, column.minibatches),
            judges,
            Progress(settings, report),
            settings.evaluate_every,
            threads,
            unfinished,
        )
        steps = settings.updates * column.rollout_steps * environments.num_envs
        resumed = listener.resume(model)
        before = torch.get_num_threads()
        try:
            missing = steps - model.num_timesteps
            model.learn(missing, listener, log_interval=None, reset_num_timesteps=not resumed)
        finally:
            torch.set_num_threads(before)
        listener.finish()
        return listener.progress.trained()


def make_model(
    environments: VecEnv, seed: int, shared: bool = True, column: Hyperparameters = REACH
) -> PPO:
    """A model that has not learned yet.

    Args:
        shared: whether policy and value share their hidden layers.
    """
    normal = {"norm_obs": column.normalised, "norm_reward": column.normalised}
    model = PPO(
        _BoundedPolicy,
        VecNormalize(environments, clip_obs=CLIPPED_AT, gamma=GAMMA, **normal),
        learning_rate=column.learning_rate,
        n_steps=column.rollout_steps,
        batch_size=column.rollout_steps * environments.num_envs // column.minibatches,
        n_epochs=EPOCHS,
        gamma=GAMMA,
        gae_lambda=LAMBDA,
        clip_range=CLIP,
        clip_range_vf=CLIP,
        ent_coef=column.entropy,
        vf_coef=column.value,
        max_grad_norm=GRADIENT_NORM,
        policy_kwargs=_policy_arguments(shared, column),
        rollout_buffer_class=RememberingBuffer,
        seed=seed,
        device="cpu",
    )
    # its own choice is a folder in /tmp for every training
    model.set_logger(Logger(None, []))
    return model


def _policy_arguments(shared: bool, column: Hyperparameters) -> dict[str, Any]:
    sizes = list(column.layers)
    layers = {
        "features_extractor_class": _Hidden, "features_extractor_kwargs": {"layers": sizes},
        "net_arch": [],
    } if shared else {"net_arch": sizes}  # fmt: skip
    return {
        **layers, "activation_fn": torch.nn.ELU, "optimizer_kwargs": {"fused": True},
        "min_log_std": column.min_log_std,
    }  # fmt: skip


def make_policy(
    observation_size: int,
    action_size: int,
    bound: float,
    seed: int,
    shared: bool,
    column: Hyperparameters = REACH,
) -> ActorCriticPolicy:
    """The policy that `make_model` begins with, without a model.

    Args:
        bound: of an action's elements, either way.
    """
    torch.manual_seed(seed)
    return _BoundedPolicy(
        spaces.Box(-np.inf, np.inf, (observation_size,), np.float32),
        spaces.Box(-bound, bound, (action_size,), np.float32),
        lambda _: column.learning_rate,
        **_policy_arguments(shared, column),
    )


class ActorCritic(torch.nn.Module):
    """What a policy of `make_policy` says of observations, without what surrounds it."""

    def __init__(self, policy: ActorCriticPolicy):
        super().__init__()
        self.policy = policy

    def forward(self, observation: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        """Mean of actions and logarithm of their spread (m, naction), values (m,)."""
        policy = self.policy
        features = policy.features_extractor(observation)
        actor, critic = policy.mlp_extractor(features)
        mean = policy.action_net(actor)
        log_std = policy.log_std.clamp(min=policy.min_log_std).expand_as(mean)
        return mean, log_std, policy.value_net(critic)[..., 0]


def layers_of(
    policy: ActorCriticPolicy, parameters: Mapping[str, torch.Tensor]
) -> tuple[tuple[np.ndarray, ...], tuple[np.ndarray, ...]]:
    """Weights and biases of the layers that lead to an action, out of parameters by name."""
    own = policy.mlp_extractor.policy_net
    hidden = own if len(own) else policy.features_extractor.layers
    names = {module: name for name, module in policy.named_modules()}
    layers = [*(layer for layer in hidden if hasattr(layer, "weight")), policy.action_net]
    weights, biases = (
        tuple(
            parameters[f"{names[layer]}.{kind}"].detach().cpu().double().numpy().copy()
            for layer in layers
        )
        for kind in ("weight", "bias")
    )
    return weights, biases


def export(model: PPO) -> GaussianMLP:
    """The policy of a model of `make_model` as it is, which acts by its mean."""
    statistics = model.get_vec_normalize_env()
    size = model.observation_space.shape
    mean, deviation = np.zeros(size), np.ones(size)
    if statistics.norm_obs:
        mean = statistics.obs_rms.mean.copy()
        deviation = np.sqrt(statistics.obs_rms.var + statistics.epsilon)
    weights, biases = layers_of(model.policy, dict(model.policy.named_parameters()))
    return GaussianMLP(
        mean=mean,
        deviation=deviation,
        weights=weights,
        biases=biases,
        action_scale=statistics.venv.action_scale[0],
        clipped=bool(model.action_space.high.max() <= 1),
    )


class _Hidden(BaseFeaturesExtractor):
    """Hidden layers that policy and value share, one linear layer each on top."""

    def __init__(self, observation_space: spaces.Box, layers: Sequence[int]):
        super().__init__(observation_space, layers[-1])
        sizes = [observation_space.shape[0], *layers]
        self.layers = torch.nn.Sequential()
        for before, after in pairwise(sizes):
            self.layers.append(torch.nn.Linear(before, after)).append(torch.nn.ELU())

    def forward(self, observations: torch.Tensor) -> torch.Tensor:
        return self.layers(observations)


class _BoundedPolicy(WatchedPolicy):
    """Gaussian, with a spread whose logarithm never falls below `min_log_std`."""

    def __init__(self, *arguments, min_log_std: float, **more):
        self.min_log_std = min_log_std
        super().__init__(*arguments, **more)

    def _get_action_dist_from_latent(self, latent_pi: torch.Tensor):
        mean = self.action_net(latent_pi)
        deviation = torch.ones_like(mean) * self.log_std.clamp(min=self.min_log_std).exp()
        # whether numbers are finite is checked once an update, not at every distribution
        self.action_dist.distribution = Normal(mean, deviation, validate_args=False)
        return self.action_dist


class _Listener(BaseCallback):
    """Evaluates after some updates, and keeps the state then."""

    def __init__(
        self,
        rate: AdaptiveRate,
        judges: Environments,
        progress: Progress,
        evaluate_every: int,
        threads: int,
        unfinished: Unfinished | None,
    ):
        super().__init__()
        self.unfinished = unfinished
        self.rate, self.judges, self.progress = rate, judges, progress
        self.evaluate_every, self.threads = evaluate_every, threads
        self.updates, self._resumed = -1, False
        self._rewards: list[float] = []

    def resume(self, model: PPO) -> bool:
        """Whether there was a state that the model goes on from."""
        state = self.unfinished.read() if self.unfinished else None
        if state is None:
            return False
        ppo_state.restore(model, state["model"])
        self.rate.restore(state["rate"])
        self.progress.restore(state["progress"])
        self.judges.restore(state["judges"])
        # the rollout that comes is the one that was to follow
        self.updates, self._resumed = state["updates"] - 1, True
        log.info("goes on after update %d", state["updates"])
        return True

    def _keep(self) -> None:
        if self.unfinished:
            self.unfinished.write(
                {
                    "model": ppo_state.state_of(self.model),
                    "rate": self.rate.state(),
                    "progress": self.progress.state(),
                    "judges": self.judges.state(),
                    "updates": self.updates,
                }
            )

    def _on_step(self) -> bool:
        self._rewards.append(float(self.training_env.get_original_reward().mean()))
        return not self.progress.enough

    def _on_rollout_end(self) -> None:
        torch.set_num_threads(self.threads)

    def _on_rollout_start(self) -> None:
        # small forward passes gain nothing from threads, which would get in the simulator's way
        torch.set_num_threads(1)
        self.updates += 1
        judged, self._resumed = self._resumed, False
        if not self.updates or judged:
            return
        self._check()
        if self.updates % self.evaluate_every == 0:
            self.judge()
            self._keep()

    def finish(self) -> None:
        """Evaluate the last policy too, unless training ended by an evaluation."""
        if not self.progress.enough:
            self.updates += 1
            self._check()
            self.judge()

    def judge(self) -> None:
        """Evaluate the policy as it is."""
        policy, environment = export(self.model), self.training_env.unwrapped
        self.progress.take(
            policy,
            evaluate(policy, self.judges),
            update=self.updates,
            steps=self.num_timesteps,
            reward=float(np.mean(self._rewards)) / environment.period_s,
            terms={name: float(paid[0]) for name, paid in environment.paid().items()},
            learning_rate=self.rate.rate,
        )
        self._rewards.clear()

    def _check(self) -> None:
        if not all(torch.isfinite(values).all() for values in self.model.policy.parameters()):
            raise TrainingError.not_finite(self.updates)
