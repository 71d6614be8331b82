"""Every tuned constant of the search for what a model lacks, each with its reason.

A test counts them, with those of the bootstrap and of the search without derivatives. What is not
here is physics, numerics of a formula, or the wording of a page.
"""

# ------------------------------------------------------------------------------- the three sets
FRACTION = 0.25  # of the recordings that choose, and that report: most are left to fit
WHOLE = 3  # recordings: fewer are no sample of the conditions
GUARD = 0.1  # of a block of time: residuals are alike over tens of milliseconds

# -------------------------------------------------------------------- cheaper looks at the data
MANY = 9  # recordings, from which a part tells nearly what all do; the shortlist
SCREENED = (2, 3)  # recordings every effect is tried on: the ends of the gains; their middle too
SCREENED_S = 5.0  # of a recording half as long again or longer
ALIKE = 0.5  # of a joint's mean squared error: what is cut off is no other
COARSEST = 5  # control periods a tick: more is no control loop of that machine any more
LONG = 8000  # ticks of one recording, which are simulated one after the other
NEGLIGIBLE = 0.3  # of the noise: adds 4 % to an error that is noise alone
SMALL = 0.01  # of the model's error: adds nothing to what an effect takes off it

# ------------------------------------------------------------------------------------- the race
HALVED_AFTER = 2  # iterations: enough to tell the hopeless half
ITERATIONS = 8  # at most, of those that go on: Levenberg-Marquardt has then settled
LEADERS = 4  # effects, and sets of effects, that go on to the shortlist
CLOSE_BY = 0.25  # of the spread of a search, where a fit to all recordings has ended
DIAGONAL_FROM_JOINTS = 4  # joints from which finite differences move them all at once, to save time

# ------------------------------------------------------------------------------------ decisions
MATERIAL = 0.05  # of the RMS error: a difference of less is none that a user would act on
HARMLESS = 0.005  # an effect that acts in few blocks leaves a resample without them as it was
AT_THE_FLOOR = 1.10  # times the noise floor: what remains is measurement
NEAR_THE_FLOOR = 1.25  # likewise, if no effect improves on it
MOST_EFFECTS = 8  # steps of an explanation: more is a model that fits anything
MOST_TOGETHER = 3  # effects selected at once; of more, some are found in the next step
SELECTIONS = 50  # resamples: the standard error of a share of one half is 7 %
CERTAIN = 0.5  # share of the resamples; what is selected less often is told to be uncertain
