"""Whether a model with learned laws may stand for the model with known effects.

Both predict all validation samples, which learned neither, also where these go further than the
recordings that the laws were learned from. The paired block bootstrap decides:

- laws in place of names must do the same with less, so they may not be worse: the bound says that
  the error grows to `NEAR` times at most;
- laws beside all names must earn their place: the bound says that the error falls, and it falls
  by `LEAST_IMPROVEMENT` at least.

Half of the way to the noise is enough without it: a limit may act at one moment, and half of the
draws lack that. An error of at most `NEAR` times the noise is noise, and not worse than anything.
"""

import numpy as np

from t2l.diagnose.evidence import Evidence, validation_blocks
from t2l.diagnose.judging import rms
from t2l.identify.block_bootstrap import improvement
from t2l.identify.model import Model
from t2l.identify.prediction import Request
from t2l.propose.decision import NEAR, each_goes_half_way
from t2l.propose.found import LEAST_IMPROVEMENT, SEED


def confirmed(
    laws: Model, names: Model, replaced: bool, evidence: Evidence, noise_floor_rad: float
) -> bool:
    """Whether validation samples confirm the laws.

    Args:
        laws: the model with them.
        names: the model with all known effects and no law.
        replaced: whether the laws stand in place of some of them.
    """
    predictor, mask = evidence.validation, evidence.validation_mask
    vectors = (model.vector(predictor.joints) for model in (names, laws))
    predicted = predictor.predict([Request(layout, u[None]) for layout, u in vectors])
    before, after = ((q[0] - predictor.samples.q)[mask] for q in predicted)
    if not np.isfinite(after).all():
        return False
    count = max(len(laws.learned) - len(names.learned), 1)
    if each_goes_half_way(count, rms(after), rms(before), noise_floor_rad):
        return True
    rng = np.random.default_rng(SEED)
    gain = improvement(before, after, validation_blocks(evidence), rng)
    if replaced:
        return gain.lower >= 1 - NEAR
    return gain.lower > 0 and gain.fraction >= LEAST_IMPROVEMENT
