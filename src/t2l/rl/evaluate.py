"""How a policy does over episodes of its simulator."""

import numpy as np

from t2l.policies import Policy
from t2l.rl.constraints import NAMES, Evaluation
from t2l.rl.environments import Environments


def evaluate(policy: Policy, environments: Environments) -> Evaluation:
    """One episode in every environment, which must not be staggered."""
    observation = environments.reset()
    for _ in range(environments.horizon):
        observation, _, _, infos = environments.step(policy.action(observation))
    return Evaluation(
        success=float(np.mean([info["success"] for info in infos])),
        rates={name: float(np.mean([info[name] for info in infos])) for name in NAMES},
    )
