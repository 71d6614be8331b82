"""The sections of a configuration: each key's type, unit, bounds, default and meaning.

Nowhere else is a default, a bound or an explanation of a key. Upper bounds of sizes are far above
any study and within what a machine can hold.
"""

from t2l.config.models.configuration import Configuration

__all__ = ["Configuration"]
