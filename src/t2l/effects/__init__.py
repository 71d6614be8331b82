"""Physical effects that a model may lack, each in a file of its own."""

from t2l.effects.effect import Effect, Parameter, Scales, Values

__all__ = ["Effect", "Parameter", "Scales", "Values"]
