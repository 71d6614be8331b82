"""PPO of stable-baselines3 with the study's hyper-parameters."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import Logger
from stable_baselines3.common.vec_env import VecNormalize

from t2l.errors import T2LError
from t2l.rl.adaptive_rate import AdaptiveRate, RememberingBuffer, WatchedPolicy
from t2l.rl.constraints import Evaluation
from t2l.rl.environments import Environments
from t2l.rl.evaluate import evaluate
from t2l.rl.policy import CLIPPED_AT, ReachPolicy
from t2l.rl.settings import Settings

if TYPE_CHECKING:
    import pandas as pd

ROLLOUT_STEPS = 24
MINIBATCHES = 4
EPOCHS = 5
GAMMA = 0.99
MIN_LOG_STD = -3.0
FIRST_RATE = 1e-3


class TrainingError(T2LError):
    """Training left a policy that is not finite."""


@dataclass(frozen=True, eq=False)
class Trained:
    """The best policy that was evaluated.

    Attributes:
        history: one row an evaluation: update, steps, seconds, reward a step, success, the
            constraints' shares, learning rate.
    """

    policy: ReachPolicy
    evaluation: Evaluation
    history: "pd.DataFrame"


def train(
    environments: Environments,
    judges: Environments,
    settings: Settings,
    report: Callable[[int, Evaluation], None] = lambda update, evaluation: None,
) -> Trained:
    """Train in `environments`, judge in `judges`, which are not staggered.

    Args:
        report: called after each evaluation; what it raises ends training.

    Raises:
        TrainingError: an update left numbers that are not finite.
    """
    import pandas as pd

    normalised = VecNormalize(environments, clip_obs=CLIPPED_AT, gamma=GAMMA)
    ppo = _ppo(normalised, settings.seed)
    listener = _Listener(AdaptiveRate(ppo, FIRST_RATE), judges, settings, report)
    steps = settings.updates * ROLLOUT_STEPS * environments.num_envs
    try:
        ppo.learn(steps, listener, log_interval=None)
    except ValueError:
        # torch refuses a distribution whose mean is not a number
        if all(torch.isfinite(values).all() for values in ppo.policy.parameters()):
            raise
        raise listener.not_finite() from None
    listener.finish()
    return Trained(listener.best, listener.best_evaluation, pd.DataFrame(listener.history))


# whether an update left a finite policy is checked once an update, not at every distribution
torch.distributions.Distribution.set_default_validate_args(False)


class _BoundedPolicy(WatchedPolicy):
    """Gaussian, with a spread that never falls below `MIN_LOG_STD`."""

    def _get_action_dist_from_latent(self, latent_pi: torch.Tensor):
        spread = self.log_std.clamp(min=MIN_LOG_STD)
        return self.action_dist.proba_distribution(self.action_net(latent_pi), spread)


def _ppo(environments: VecNormalize, seed: int) -> PPO:
    ppo = PPO(
        _BoundedPolicy,
        environments,
        learning_rate=FIRST_RATE,
        n_steps=ROLLOUT_STEPS,
        batch_size=ROLLOUT_STEPS * environments.num_envs // MINIBATCHES,
        n_epochs=EPOCHS,
        gamma=GAMMA,
        gae_lambda=0.95,
        clip_range=0.2,
        clip_range_vf=0.2,
        ent_coef=0.01,
        max_grad_norm=1.0,
        policy_kwargs={
            "net_arch": [64, 64],
            "activation_fn": torch.nn.ELU,
            "optimizer_kwargs": {"fused": True},
        },
        rollout_buffer_class=RememberingBuffer,
        seed=seed,
        device="cpu",
    )
    # its own choice is a folder in /tmp for every training
    ppo.set_logger(Logger(None, []))
    return ppo


class _Listener(BaseCallback):
    """Evaluates after some updates, and keeps the best policy."""

    def __init__(self, rate: AdaptiveRate, judges: Environments, settings: Settings, report):
        super().__init__()
        self.rate = rate
        self.judges, self.settings, self.report = judges, settings, report
        self.threads = torch.get_num_threads()
        self.updates, self.began = -1, time.perf_counter()
        self.history: list[dict] = []
        self.best: ReachPolicy | None = None
        self.best_evaluation: Evaluation | None = None
        self._rewards: list[float] = []
        self._ended = False

    def _on_step(self) -> bool:
        self._rewards.append(float(self.training_env.get_original_reward().mean()))
        return not self._ended

    def _on_rollout_end(self) -> None:
        torch.set_num_threads(self.threads)

    def _on_rollout_start(self) -> None:
        # small forward passes gain nothing from threads, which would get in the simulator's way
        torch.set_num_threads(1)
        self.updates += 1
        if not np.isfinite(self.rate.kl):
            raise self.not_finite()
        if self.updates and self.updates % self.settings.evaluate_every == 0:
            self.judge()

    def finish(self) -> None:
        """Evaluate the last policy too, unless training ended by an evaluation."""
        if not self._ended:
            self.updates += 1
            self.judge()

    def not_finite(self) -> TrainingError:
        """What to tell the user."""
        return TrainingError(
            f"training: update {self.updates} left a policy that is not finite; allowed: finite "
            "rewards; try smaller action scales or reward weights"
        )

    def judge(self) -> None:
        """Evaluate the policy as it is, and keep it if it is the best so far."""
        policy = _exported(self.model)
        found = evaluate(policy, self.judges)
        self.history.append(
            {
                "update": self.updates,
                "steps": self.num_timesteps,
                "seconds": time.perf_counter() - self.began,
                "reward": float(np.mean(self._rewards)),
                "success": found.success,
                **found.rates,
                "objective": found.objective,
                "learning_rate": self.rate.rate,
            }
        )
        self._rewards.clear()
        best = self.best_evaluation
        if best is None or found.objective > best.objective:
            self.best, self.best_evaluation = policy, found
        self._ended = found.objective >= 1 + self.settings.enough
        self.report(self.updates, found)


def _exported(model: PPO) -> ReachPolicy:
    statistics = model.get_vec_normalize_env()
    layers = [
        layer for layer in model.policy.mlp_extractor.policy_net if hasattr(layer, "weight")
    ] + [model.policy.action_net]
    return ReachPolicy(
        mean=statistics.obs_rms.mean.copy(),
        deviation=np.sqrt(statistics.obs_rms.var + statistics.epsilon),
        weights=tuple(layer.weight.detach().double().numpy().copy() for layer in layers),
        biases=tuple(layer.bias.detach().double().numpy().copy() for layer in layers),
        action_scale=statistics.venv.action_scale,
    )
