"""Three disjoint sets of what was recorded: to fit, to choose by, and to report the error of.

Training samples fit parameters. Validation samples decide all that is decided: which effect is
adopted, which is removed, what is tied. Test samples do neither and report the error.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import isqrt

import numpy as np

from t2l.diagnose import settings
from t2l.identify.block_bootstrap import BLOCK_S, blocks
from t2l.identify.initial_state import half_begin_in_motion
from t2l.identify.levels import SHORTLISTED
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor
from t2l.identify.step_size import substeps_for
from t2l.recordings.recording import Recording
from t2l.recordings.splits import LEAST_TO_HOLD_OUT_WHOLE, hold_out, time_blocks

# whose a block of time is, in turn
TWO_SETS = ("train", "validation")
THREE_SETS = ("train", "validation", "train", "test")


@dataclass(frozen=True)
class Evidence:
    """Samples to fit, to choose by and to report, and fewer of the first to try everything on.

    Attributes:
        train, validation, test: predictors; one and the same where blocks of time are taken.
        shortlist, screen: predictors of some of the training recordings, or of all if few.
        train_mask, …: (nsample,) bool of each predictor's samples.
        split: what became validation and test samples, in words.
    """

    train: Predictor
    train_mask: np.ndarray
    validation: Predictor
    validation_mask: np.ndarray
    test: Predictor
    test_mask: np.ndarray
    shortlist: Predictor
    shortlist_mask: np.ndarray
    screen: Predictor
    screen_mask: np.ndarray
    split: str


def gather(
    robot: str,
    recordings: Sequence[Recording],
    holdout: Sequence[Recording] = (),
    substeps: int = 1,
    threads: int | None = None,
    by_blocks: bool = False,
) -> Evidence:
    """Split what was recorded.

    `holdout`, or else whole recordings where there are three, or else blocks of time report. Of
    the rest, whole recordings choose where each condition is likely to be left to fit, or else
    blocks of time. What is left is fitted.

    Args:
        by_blocks: let blocks of time choose, however many recordings there are.
    """
    rest, test = list(recordings), list(holdout)
    in_motion = half_begin_in_motion((*rest, *test))

    def predictor(of: Sequence[Recording]) -> Predictor:
        return Predictor(robot, of, substeps, threads, in_motion=in_motion)

    reports = "the recordings given"
    if not test and len(rest) >= LEAST_TO_HOLD_OUT_WHOLE:
        rest, test = hold_out(rest, settings.FRACTION, seed=0)
        reports = "whole recordings"
    if len(rest) > LEAST_TO_HOLD_OUT_WHOLE and not by_blocks:
        rest, chosen = hold_out(rest, settings.FRACTION, seed=1)
        train, validation = (predictor(each) for each in (rest, chosen))
        masks, chooses = [_all(train), _all(validation)], "whole recordings"
    else:
        train = validation = predictor(rest)
        masks, chooses = sets_by_time(train, TWO_SETS if test else THREE_SETS), "blocks of time"
    if test:
        tested = predictor(test)
        masks = [*masks[:2], _all(tested)]
    else:
        tested, reports = train, "blocks of time"
    return Evidence(
        train, masks[0], validation, masks[1], tested, masks[2],
        *_over_the_gains(train, masks[0], SHORTLISTED), *_screened(train, masks[0]),
        f"validation: {chooses}; test: {reports}",
    )  # fmt: skip


def pooled(evidence: Evidence) -> Evidence:
    """The same test samples, and blocks of time of all other recordings to fit and to choose by."""
    train, choose, test = evidence.train, evidence.validation, evidence.test
    recordings = [*train.recordings, *choose.recordings]
    return gather(
        train.robot, recordings, test.recordings, train.substeps, train.threads, by_blocks=True
    )


def fine_enough(model: Model, evidence: Evidence) -> Evidence:
    """The same samples, simulated with as many physics steps as the model needs.

    An effect may need more than the model needs without it.
    """
    sets = dict.fromkeys((evidence.train, evidence.validation))
    recordings = [recording for each in sets for recording in each.recordings]
    needed = substeps_for(model, recordings)
    if needed <= evidence.train.substeps:
        return evidence
    finer: dict[int, Predictor] = {}
    for name in ("train", "validation", "test", "shortlist", "screen"):
        old = getattr(evidence, name)
        if id(old) not in finer:
            finer[id(old)] = Predictor(
                old.robot, old.recordings, needed, old.threads, in_motion=old.in_motion
            )
        evidence = replace(evidence, **{name: finer[id(old)]})
    return evidence


def sets_by_time(predictor: Predictor, sets: Sequence[str]) -> list[np.ndarray]:
    """Masks (nsample,) of two or three sets: blocks of time in turn, with a guard at each edge.

    Residuals are alike over a short time, so that samples beside an edge belong to no set.
    """
    turns, samples = np.array(sets), predictor.samples
    of = np.full(len(samples), "guard", turns.dtype)
    for i, recording in enumerate(predictor.recordings):
        block_s = min(2 * BLOCK_S, recording.duration_s / (2 * len(turns)))
        at = np.flatnonzero(samples.recording == i)
        block = time_blocks(recording, block_s)[samples.row[at]]
        inside = (block == 0) | (samples.time[at] >= (block + settings.GUARD) * block_s)
        of[at[inside]] = turns[block[inside] % len(turns)]
    if not set(turns) <= set(of):  # sampled too rarely for blocks
        of = turns[samples.row % len(turns)]
    return [of == which for which in ("train", "validation", "test")]


def validation_blocks(evidence: Evidence) -> np.ndarray:
    """(n,) which block of time each validation sample belongs to, the unit that is resampled."""
    samples, mask = evidence.validation.samples, evidence.validation_mask
    return blocks(samples.recording[mask], samples.time[mask])


def deciding(evidence: Evidence) -> tuple[Predictor, np.ndarray]:
    """Training and validation samples together, of some recordings if there are many."""
    train, choose = evidence.train, evidence.validation
    if choose is train:
        return _over_the_gains(train, evidence.train_mask | evidence.validation_mask, SHORTLISTED)
    both = train.of([*train.recordings, *choose.recordings])
    mask = np.concatenate([evidence.train_mask, evidence.validation_mask])
    return _over_the_gains(both, mask, SHORTLISTED)


def screened(predictor: Predictor) -> Predictor:
    """A predictor of the few recordings that every effect is tried on."""
    return _screened(predictor, _all(predictor))[0]


def some(predictor: Predictor, mask: np.ndarray, count: int) -> tuple[Predictor, np.ndarray]:
    """A predictor of `count` of the recordings, spread over their order, and its part of `mask`."""
    return _part(predictor, mask, np.arange(len(predictor.recordings)), count)


def _screened(predictor: Predictor, mask: np.ndarray) -> tuple[Predictor, np.ndarray]:
    few, more = settings.SCREENED
    count = min(max(isqrt(len(predictor.recordings)), few), more)
    return _over_the_gains(predictor, mask, count)


def _over_the_gains(
    predictor: Predictor, mask: np.ndarray, count: int
) -> tuple[Predictor, np.ndarray]:
    recordings = predictor.recordings
    order = sorted(range(len(recordings)), key=lambda i: (*recordings[i].kp, *recordings[i].kd))
    return _part(predictor, mask, np.array(order), count)


def _part(
    predictor: Predictor, mask: np.ndarray, order: np.ndarray, count: int
) -> tuple[Predictor, np.ndarray]:
    if count >= len(order):
        return predictor, mask
    chosen = np.sort(order[np.round(np.linspace(0, len(order) - 1, count)).astype(int)])
    part = predictor.of([predictor.recordings[i] for i in chosen])
    return part, mask[np.isin(predictor.samples.recording, chosen)]


def _all(predictor: Predictor) -> np.ndarray:
    return np.ones(len(predictor.samples), bool)
