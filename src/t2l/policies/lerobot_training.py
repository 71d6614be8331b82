"""Training of a policy as lerobot's own script trains it, on windows of episodes in memory."""

from collections.abc import Iterator, Sequence

import numpy as np
import torch
from torch import Tensor

from t2l.policies.lerobot_network import LeRobotNetwork
from t2l.policies.lerobot_policy import LeRobotSettings
from t2l.policies.policy import Episode
from t2l.policies.windows import around


class Samples:
    """Windows of some episodes as lerobot's data sets give them, normalised already."""

    def __init__(self, episodes: Sequence[Episode], network: LeRobotNetwork):
        from lerobot.utils.constants import ACTION

        config, device = network.policy.config, network.action_mean.device
        self._frames = network.normalised(
            np.concatenate([e.observation for e in episodes]),
            np.concatenate([e.action for e in episodes]),
        )
        lengths = [len(e.action) for e in episodes]
        self._steps, self._beyond = {}, {}
        for name in self._frames:
            offsets = (
                config.action_delta_indices if name == ACTION else config.observation_delta_indices
            )
            index, beyond = around(lengths, [0] if offsets is None else offsets)
            if offsets is None:
                index, beyond = index[:, 0], beyond[:, 0]
            self._steps[name] = torch.as_tensor(index, device=device)
            self._beyond[f"{name}_is_pad"] = torch.as_tensor(beyond, device=device)

    def __getitem__(self, index: Tensor) -> dict[str, Tensor]:
        """The windows of steps (n,), by feature, and which of their steps no episode has."""
        found = {name: self._frames[name][steps[index]] for name, steps in self._steps.items()}
        return found | {name: beyond[index] for name, beyond in self._beyond.items()}


def epochs(
    network: LeRobotNetwork, episodes: Sequence[Episode], settings: LeRobotSettings, seed: int
) -> Iterator[float]:
    """Train a network in place; its mean loss in each epoch, when that has ended.

    Args:
        seed: of the order of windows; what the loss draws, torch's generator gives.
    """
    from lerobot.datasets.sampler import EpisodeAwareSampler

    policy, samples = network.policy, Samples(episodes, network)
    ends = np.cumsum([len(e.action) for e in episodes]).tolist()
    sampler = EpisodeAwareSampler(
        [0, *ends[:-1]],
        ends,
        drop_n_last_frames=getattr(policy.config, "drop_n_last_frames", 0),
        shuffle=True,
        seed=seed,
    )
    steps = settings.epochs * -(-len(sampler) // settings.batch_size)
    preset, schedule = policy.config.get_optimizer_preset(), policy.config.get_scheduler_preset()
    optimiser = preset.build(policy.get_optim_params())
    schedule = schedule and schedule.build(optimiser, steps)
    device = network.action_mean.device
    for _ in range(settings.epochs):
        network.train()
        # on the device, as a GPU would be waited for at every step to be asked
        total = torch.zeros((), device=device)
        for index in torch.tensor(list(sampler), device=device).split(settings.batch_size):
            loss, _ = policy.forward(samples[index])
            optimiser.zero_grad()
            loss.backward()
            torch.nn.utils.clip_grad_norm_(policy.parameters(), preset.grad_clip_norm)
            optimiser.step()
            if schedule:
                schedule.step()
            total += len(index) * loss.detach()
        network.eval()
        yield float(total) / len(sampler)
