"""Every tuned constant of the search for what a model lacks, each with its reason.

A test counts them. What is not here is physics, numerics of a formula, or the wording of a page.
"""

# ------------------------------------------------------------------------------- the three sets
TEST_FRACTION = 0.2  # of the recordings: a few are enough to report an error
VALIDATION_FRACTION = 0.3  # of those that do not report: fewer choose than fit
WHOLE_TO_REPORT = 3  # recordings; with fewer each has conditions of its own
WHOLE_TO_CHOOSE = 4  # likewise, once those that report are gone, and three are left to fit
BLOCK_S = 1.0  # longer than a response lasts, short enough that each set sees each motion
GUARD = 0.1  # of a block: residuals are alike over tens of milliseconds

# -------------------------------------------------------------------- cheaper looks at the data
MANY = 9  # recordings, from which a part tells nearly what all do
SCREENED = (2, 3)  # recordings every effect is tried on: the ends of the gains; their middle too
SHORTLISTED = 12  # recordings the likeliest are fitted on
SCREENED_S = 5.0  # of a recording half as long again or longer
ALIKE = 0.5  # of a joint's mean squared error: what is cut off is no other
COARSENESS = (5, 4, 2)  # control periods a tick that are tried
LONG = 8000  # ticks of one recording, which are simulated one after the other
NEGLIGIBLE = 0.3  # of the noise: adds 4 % to an error that is noise alone
SMALL = 0.01  # of the model's error: adds nothing to what an effect takes off it

# ------------------------------------------------------------------------------------- the race
FIRST_ITERATIONS = 3  # of every fit: enough to tell the hopeless half
MORE_ITERATIONS = 5  # of the better half: Levenberg-Marquardt has then settled
LEADERS = 4  # effects, and sets of effects, that go on to the shortlist
SCREENING_TOLERANCE = 5e-3  # relative decrease of the loss that counts as none while screening
SEARCHED = 2  # recordings on which rough effects are searched, in a hundred simulations each
CLOSE_BY = 0.25  # of the spread of a search, where a fit to all recordings has ended
DIAGONAL_FROM_JOINTS = 4  # joints from which finite differences move them all at once
LEAST_SIZE = 1e-3  # of an adopted parameter, for finite differences
JOINTS_TRIED = 3  # alone, those with most of the error; each takes a fit of its own
INSIGNIFICANT = 2.0  # standard errors from neutral: 95 % of effects that are absent
IDLE = 1.01  # times the squared error that is left with an effect: without it no more

# ------------------------------------------------------------------------------------ decisions
MATERIAL = 0.05  # of the RMS error: a difference of less is none that a user would act on
HARMLESS = 0.005  # an effect that acts in few blocks leaves a resample without them as it was
AT_THE_FLOOR = 1.10  # times the noise floor: what remains is measurement
NEAR_THE_FLOOR = 1.25  # likewise, if no effect improves on it
MOST_EFFECTS = 8  # steps of an explanation
MOST_TOGETHER = 3  # effects selected at once; of more, some are found in the next step
SELECTIONS = 50  # resamples: the standard error of a share of one half is 7 %
CERTAIN = 0.5  # share of the resamples; what is selected less often is told to be uncertain
