"""Ratios and shares that decide what is the same and what is not, one for each question."""

# tuned: of an error or what it is made of: less is none that a user would act on
MATERIAL = 0.05
NOTHING = 0.005  # tuned: of an error: less is no difference at all
TIED = 0.03  # tuned: of an error: models that differ by less explain alike
AT_THE_FLOOR = 1.10  # tuned: times the noise, or the least error: what is as near is as good
HALF = 0.5  # tuned: of a whole, or of the best: less is no more like it than unlike
PROMISING = 1.5  # tuned: times an error that is as good: what may still turn out to be
# derived: of the noise: what adds no more than a tie to an error that is noise alone
NEGLIGIBLE = ((1 + TIED) ** 2 - 1) ** 0.5
SHORTLISTED = 12  # tuned: recordings, of many, that tell nearly what all do
