"""Constants of the three sets and of the selection over resamples, each with its reason."""

from math import isqrt

from t2l.identify.levels import HALF, SHORTLISTED

# ------------------------------------------------------------------------------- the three sets
FRACTION = 0.25  # tuned: of the recordings that choose, and that report: most are left to fit
GUARD = 0.1  # tuned: of a block of time: residuals are alike over tens of milliseconds

# -------------------------------------------------------------------- cheaper looks at the data
# derived: recordings every effect is tried on, the root of all: both ends of the gains at least,
# and no more than the root of what is shortlisted
SCREENED = (2, isqrt(SHORTLISTED))

# ------------------------------------------------------------------------------------ decisions
# tuned: steps of an explanation, and effects selected at once: more is a model that fits anything
MOST_EFFECTS = 8
LEAST_BLOCKS = 5  # statistics: of time: a resample of fewer leaves too little to fit or to judge by
SELECTIONS = 50  # statistics: resamples: the standard error of a share of one half is 7 %
# in 109 development cases all 12 effects that were adopted with less were wrong
LEAST_SHARE = 0.1  # tuned: of the resamples; what serves in fewer is not adopted
CERTAIN = HALF  # of the resamples; what serves in fewer is told to be uncertain

# ------------------------------------------------------------------------------ position loops
FASTEST_HZ = 8.0  # bound: of a motion: beyond what a controlled joint follows
