"""Every tuned constant of the search for what a model lacks, each with its reason.

A test counts them. What is not here is physics, numerics of a formula, or the wording of a page.
"""

# ------------------------------------------------------------------------------- the three sets
TEST_FRACTION = 0.2  # of the recordings: a few are enough to report an error
VALIDATION_FRACTION = 0.3  # of those that do not report: fewer choose than fit
WHOLE_TO_REPORT = 3  # recordings; with fewer each has conditions of its own
WHOLE_TO_CHOOSE = 6  # likewise, once those that report are gone
BLOCK_S = 1.0  # longer than a response lasts, short enough that each set sees each motion
GUARD = 0.1  # of a block: residuals are alike over tens of milliseconds

# -------------------------------------------------------------------- cheaper looks at the data
MANY = 9  # recordings, from which a part tells nearly what all do
SCREENED = (2, 3)  # recordings every effect is tried on: the ends of the gains, their middle
SHORTLISTED = 12  # recordings the likeliest are fitted on
