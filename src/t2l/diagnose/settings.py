"""Tuned constants of the three sets and of the selection over resamples, each with its reason."""

# ------------------------------------------------------------------------------- the three sets
FRACTION = 0.25  # of the recordings that choose, and that report: most are left to fit
WHOLE = 3  # recordings: fewer are no sample of the conditions
GUARD = 0.1  # of a block of time: residuals are alike over tens of milliseconds

# -------------------------------------------------------------------- cheaper looks at the data
MANY = 9  # recordings, from which a part tells nearly what all do
SCREENED = (2, 3)  # recordings every effect is tried on: the ends of the gains; their middle too
SHORTLISTED = 12  # recordings the likeliest are fitted on

# ------------------------------------------------------------------------------------ decisions
MATERIAL = 0.05  # of the RMS error: a difference of less is none that a user would act on
AT_THE_FLOOR = 1.10  # times the noise floor: what remains is measurement
MOST_EFFECTS = 8  # steps of an explanation: more is a model that fits anything
MOST_TOGETHER = 3  # effects selected at once; of more, some are found in the next step
LEAST_BLOCKS = 5  # of time: a resample of fewer leaves too little to fit or to judge by
SELECTIONS = 50  # resamples: the standard error of a share of one half is 7 %
# in 109 development cases all 12 effects that were adopted with less were wrong
LEAST_SHARE = 0.1  # of the resamples; what serves in fewer is not adopted
CERTAIN = 0.5  # share of the resamples; what serves in fewer is told to be uncertain
