"""How policies do over episodes of their simulators."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from t2l.environment.limits import NAMES
from t2l.policies import Policy
from t2l.policies.gaussian_mlp import CLIPPED_AT, GaussianMLP
from t2l.rl.results import Evaluation
from t2l.sim.arrays import namespace

if TYPE_CHECKING:
    from t2l.environment.environment import Environment
    from t2l.rl.environments import Environments


def evaluate(policy: Policy, environments: "Environments") -> Evaluation:
    """One episode in every environment, which must not be staggered."""
    observation, first = environments.reset(), {}
    for _ in range(environments.horizon):
        observation, _, done, infos = environments.step(policy.action(observation))
        for i in np.flatnonzero(done):
            first.setdefault(int(i), infos[i])
    infos = first.values()
    return Evaluation(
        success=float(np.mean([info["success"] for info in infos])),
        rates={name: float(np.mean([info[name] for info in infos])) for name in NAMES},
        failed=float(np.mean([not info["TimeLimit.truncated"] for info in infos])),
        jitter_rad_s=float(np.mean([info["jitter_rad_s"] for info in infos])),
        effort=float(np.mean([info["effort"] for info in infos])),
    )


def evaluate_side_by_side(
    policies: Sequence[GaussianMLP], world: "Environment"
) -> list[Evaluation]:
    """Each policy in the robots of its generator, which must not be staggered, an episode each."""
    observation, act = world.begin(), _Together(policies, world)
    success, failed, seen = np.zeros((3, world.rows), bool)
    jitter, effort = np.zeros((2, world.rows))
    violated = np.zeros((world.rows, len(NAMES)), bool)
    for _ in range(world.horizon):
        observation, _, ended = world.advance(act(observation))
        first = ~seen[ended.ids]
        ids = ended.ids[first]
        success[ids], violated[ids], seen[ids] = ended.success[first], ended.violated[first], True
        failed[ids] = ended.failed[first]
        jitter[ids], effort[ids] = ended.jitter[first], ended.effort[first]
    success, *others = (
        own.reshape(len(policies), -1).mean(axis=1).tolist()
        for own in (success, failed, jitter, effort)
    )
    rates = violated.reshape(len(policies), -1, len(NAMES)).mean(axis=1).tolist()
    return [
        Evaluation(share, dict(zip(NAMES, own, strict=True)), *other)
        for share, own, *other in zip(success, rates, *others, strict=True)
    ]


class _Together:
    """Policies of one shape, each acting for the robots of its generator."""

    def __init__(self, policies: Sequence[GaussianMLP], world: "Environment"):
        self._n, self._clipped = len(policies), policies[0].clipped
        self._mean, self._deviation = (
            world.array(np.stack([getattr(p, name) for p in policies])[:, None])
            for name in ("mean", "deviation")
        )
        self._layers = [
            (
                world.array(np.stack([p.weights[i].T for p in policies])),
                world.array(np.stack([p.biases[i] for p in policies])[:, None]),
            )
            for i in range(len(policies[0].weights))
        ]

    def __call__(self, observation):
        xp = namespace(self._mean)
        size = observation.shape[1]
        x = xp.reshape(observation, (self._n, -1, size))
        x = xp.clip((x - self._mean) / self._deviation, -CLIPPED_AT, CLIPPED_AT)
        *hidden, (weight, bias) = self._layers
        for before, offset in hidden:
            x = x @ before + offset
            x = xp.where(x > 0, x, xp.expm1(xp.clip(x, None, 0.0)))
        x = x @ weight + bias
        x = xp.clip(x, -1.0, 1.0) if self._clipped else x
        return xp.reshape(x, (-1, x.shape[2]))
