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

# ------------------------------------------------------------------------------------ decisions
MATERIAL = 0.05  # of the RMS error: a difference of less is none that a user would act on
HARMLESS = 0.005  # an effect that acts in few blocks leaves a resample without them as it was
MOST_TOGETHER = 3  # effects selected at once; of more, some are found in the next step
CERTAIN = 0.5  # share of the resamples; what is selected less often is told to be uncertain
SELECTIONS = 50  # resamples: the standard error of a share of one half is 7 %

# ------------------------------------------------------------------------------------- the race
FIRST_ITERATIONS = 3  # of every fit: enough to tell the hopeless half
MORE_ITERATIONS = 5  # of the better half: Levenberg-Marquardt has then settled
LEADERS = 4  # effects, and sets of effects, that go on to the shortlist
SCREENING_TOLERANCE = 5e-3  # relative decrease of the loss that counts as none while screening
SEARCHED = 2  # recordings on which rough effects are searched, in a hundred simulations each
DIAGONAL_FROM_JOINTS = 4  # joints from which finite differences move them all at once
LEAST_SIZE = 1e-3  # of an adopted parameter, for finite differences
REFINEMENTS = 3  # iterations on all recordings between new derivatives, which are dear there
RESTARTS = 2  # times that derivatives are taken anew there
SETTLED = 0.97  # of the loss before; a fit that ends above is at its minimum
FINISHING = 1  # rounds on every tick, after a fit to coarse simulations
LOST = 1.2  # times the loss that a coarse simulation left: a fine one is fitted from the start
CLOSE_BY = 0.25  # of the spread of a search, where a fit to all recordings has ended
