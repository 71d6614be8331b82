"""Constants of the three sets and of the selection over resamples, each with its reason."""

# ------------------------------------------------------------------------------- the three sets
FRACTION = 0.25  # tuned: of the recordings that choose, and that report: most are left to fit
GUARD = 0.1  # tuned: of a block of time: residuals are alike over tens of milliseconds

# -------------------------------------------------------------------- cheaper looks at the data
# tuned: recordings every effect is tried on, the root of all: the ends of the gains; the middle too
SCREENED = (2, 3)

# ------------------------------------------------------------------------------------ decisions
MOST_EFFECTS = 8  # tuned: steps of an explanation: more is a model that fits anything
MOST_TOGETHER = 3  # tuned: effects selected at once; of more, some are found in the next step
LEAST_BLOCKS = 5  # statistics: of time: a resample of fewer leaves too little to fit or to judge by
SELECTIONS = 50  # statistics: resamples: the standard error of a share of one half is 7 %
# in 109 development cases all 12 effects that were adopted with less were wrong
LEAST_SHARE = 0.1  # tuned: of the resamples; what serves in fewer is not adopted
CERTAIN = 0.5  # statistics: share of the resamples; what serves in fewer is told to be uncertain
