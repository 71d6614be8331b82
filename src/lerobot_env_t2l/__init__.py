"""t2l's tasks as an environment of lerobot: `lerobot-eval --env.type=t2l`.

lerobot imports what an installed distribution with a name that begins with `lerobot_env_` names;
`pyproject.toml` beside this file is that distribution. Importing registers the environment.
"""

from lerobot_env_t2l.config import T2LEnvConfig

__all__ = ["T2LEnvConfig"]
