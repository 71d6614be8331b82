"""Policies: from what was observed to what is to be done, their training on episodes, their files.

Nothing outside knows a policy's class: a name leads to it (`POLICIES`), and so does a file
(`t2l.policies.checkpoint.load`).
"""

from t2l.policies.policy import ClonedPolicy, Episode, Pictures, Policy, TrainingSet
from t2l.policies.registry import POLICIES

__all__ = ["POLICIES", "ClonedPolicy", "Episode", "Pictures", "Policy", "TrainingSet"]
