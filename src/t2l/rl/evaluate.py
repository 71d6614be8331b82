"""How a policy does over episodes of its simulator."""

import numpy as np

from t2l.rl.constraints import NAMES, Evaluation
from t2l.rl.environments import Environments
from t2l.rl.policy import ReachPolicy


def evaluate(policy: ReachPolicy, environments: Environments) -> Evaluation:
    """One episode in every environment, which must not be staggered."""
    observation = environments.reset()
    for _ in range(environments.horizon):
        observation, _, _, infos = environments.step(policy.act(observation))
    return Evaluation(
        success=float(np.mean([info["success"] for info in infos])),
        rates={name: float(np.mean([info[name] for info in infos])) for name in NAMES},
    )
