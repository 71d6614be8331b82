"""Action spaces: what a policy's output means, for retargeting, rollouts, RL and deployment."""

from t2l.actions.action_space import ActionSpace
from t2l.actions.control import Control, make_control
from t2l.actions.registry import ACTIONS

__all__ = ["ACTIONS", "ActionSpace", "Control", "make_control"]
