"""What came of fitting each known effect alone: which of them the model lacks, and the verdict."""

from dataclasses import dataclass

from t2l.diagnose.candidate import Candidate
from t2l.identify.levels import AT_THE_FLOOR
from t2l.identify.model import Model, from_vector

MISSING, NOTHING_MISSING, UNEXPLAINED = "missing_effect", "no_missing_effect", "unexplained"

# derived: times the noise floor: likewise, if no effect improves on it
NEAR_THE_FLOOR = AT_THE_FLOOR**2


@dataclass
class Diagnosis:
    """What was found.

    Attributes:
        verdict: one of `missing_effect`, `no_missing_effect`, `unexplained`.
        noise_floor_rad: RMS error of a perfect model.
        train_rmse_rad, validation_rmse_rad, test_rmse_rad: of the model so far. The test
            samples chose nothing.
        ranking: candidates, in the order of `t2l.diagnose.candidate.rank`.
    """

    model: Model
    joints: tuple[str, ...]
    verdict: str
    noise_floor_rad: float
    train_rmse_rad: float
    validation_rmse_rad: float
    test_rmse_rad: float
    ranking: list[Candidate]


def verdict_of(error: float, floor: float, justified: bool) -> str:
    """Of a validation error and a noise floor, rad, and whether an effect earns its place."""
    if error <= AT_THE_FLOOR * floor:
        return NOTHING_MISSING
    if justified:
        return MISSING
    return NOTHING_MISSING if error <= NEAR_THE_FLOOR * floor else UNEXPLAINED


def adopt(diagnosis: Diagnosis, name: str) -> Model:
    """The model with effect `name` of the ranking and the parameters fitted with it."""
    candidate = next(c for c in diagnosis.ranking if c.effect.name == name)
    return from_vector(diagnosis.model, candidate.layout, candidate.u, diagnosis.joints)
