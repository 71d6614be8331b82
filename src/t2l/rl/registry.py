"""Where `reinforcement_learning.algorithm` becomes a class."""

from t2l.registry import Registry
from t2l.rl.algorithm import Algorithm

ALGORITHMS: Registry[Algorithm] = Registry(
    "algorithm", Algorithm, {"ppo": "t2l.rl.ppo:ProximalPolicyOptimisation"}
)
