"""An algorithm of one's own, a random search, and the linear policy that it finds."""

import numpy as np

from t2l.policies import Policy
from t2l.rl.algorithm import Algorithm
from t2l.rl.evaluate import evaluate
from t2l.rl.progress import Progress


class Linear(Policy):
    """a = G o, within [-1, 1]."""

    name = "linear"
    history = chunk = 1

    def __init__(self, gain, scale):
        self.gain, self.action_scale = gain, scale
        self.action_size, self.observation_size = gain.shape

    def act(self, history):
        return np.clip(history @ self.gain.T, -1, 1)

    def tensors(self):
        return {"gain": self.gain, "scale": self.action_scale}

    def metadata(self):
        return {}

    @classmethod
    def restored(cls, tensors, metadata):
        return cls(tensors["gain"], tensors["scale"])


class RandomSearch(Algorithm):
    """Draws policies, and keeps the best."""

    name = "random_search"

    def train(self, environments, judges, settings, report=lambda *_: None, threads=1):
        progress = Progress(settings, report)
        draw = np.random.default_rng(settings.seed)
        shape = environments.action_space.shape + environments.observation_space.shape
        scale = environments.actions.scale
        for update in range(1, 1 + settings.updates):
            policy, rewards = Linear(draw.normal(size=shape), scale), []
            observation = environments.reset()
            for _ in range(5):
                observation, reward, *_ = environments.step(policy.action(observation))
                rewards.append(reward.mean())
            found, steps = evaluate(policy, judges), 5 * update * len(observation)
            progress.take(policy, found, update, steps, np.mean(rewards))
            if progress.enough:
                break
        return progress.trained()
