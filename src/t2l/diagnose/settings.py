"""Shares of the recordings and of resamples, each with its reason."""

from t2l.identify.levels import HALF

FRACTION = 0.25  # tuned: of the recordings that report: most are left to fit
GUARD = 0.1  # tuned: of a block of time: residuals are alike over tens of milliseconds
CERTAIN = HALF  # of the resamples; what serves in fewer is told to be uncertain
FASTEST_HZ = 8.0  # bound: of a motion: beyond what a controlled joint follows
