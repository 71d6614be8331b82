"""How strongly a policy answers to where the joints are: the gain of the loop that it closes."""

import numpy as np

from t2l.policies import Policy
from t2l.rl.environments import Environments

STEP_RAD = 1e-3  # a tenth of the observation noise in training; float32 still resolves 1e-4 of it


def feedback_gain(policy: Policy, environments: Environments) -> float:
    """Largest singular value of α ∂π/∂q where episodes end, rad of command per rad; their median.

    The derivative is total: what remains to the goal changes with q. Central differences, at rest.

    Args:
        environments: not staggered; one episode is run in each.
    """
    observation = environments.reset()
    for _ in range(environments.horizon - 1):
        observation, *_ = environments.step(policy.action(observation))
    q = environments.simulator.q.copy()
    still = np.zeros_like(q)
    columns = []
    for joint in range(q.shape[1]):
        step = np.zeros(q.shape[1])
        step[joint] = STEP_RAD
        ahead, behind = (
            policy.action(environments.observed_at(q + sign * step, still)) for sign in (1, -1)
        )
        # of the joints' commands: a gripper's has no derivative
        change = (policy.action_scale * (ahead - behind))[:, : q.shape[1]]
        columns.append(change / (2 * STEP_RAD))
    jacobian = np.stack(columns, axis=2)  # (n, naction, njoint)
    return float(np.median(np.linalg.norm(jacobian, ord=2, axis=(1, 2))))
