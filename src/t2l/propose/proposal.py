"""What a model lacks, proposed as learned curves, and judged on data that made none of them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from t2l.effects.law import Curve, Law
from t2l.effects.term import Layout
from t2l.identify.levels import AT_THE_FLOOR
from t2l.identify.model import Model, from_vector
from t2l.identify.prediction import Predictor, Request
from t2l.identify.progress import Progress
from t2l.identify.scales import sized
from t2l.propose.band import band
from t2l.propose.bases import tabulated
from t2l.propose.dictionary import moved, rest_in, weights_in
from t2l.propose.found import Ceiling, Search
from t2l.propose.laws import seen
from t2l.propose.learning_samples import LearningSamples
from t2l.propose.refit import State, refit
from t2l.propose.search import search
from t2l.propose.shared_constants import anchoring
from t2l.propose.split import split

LAW, NOTHING, NO_LAW = "law", "nothing_to_explain", "no_law"


@dataclass(frozen=True)
class Learned:
    """A curve with its band.

    Attributes:
        low, high: (n,) ends of the 95 % interval at each value of the curve.
        seen: the variable's ends in all recordings that formulas are simulated on; None for no
            further than `Curve.reach`.
    """

    curve: Curve
    low: np.ndarray
    high: np.ndarray
    seen: tuple[float, float] | None = None

    @property
    def reach(self) -> tuple[float, float]:
        """Ends of what a formula in the place of the curve must say."""
        ends = np.array([self.curve.reach, self.seen or self.curve.reach])
        return float(ends.min()), float(ends.max())


@dataclass(frozen=True)
class Proposal:
    """What was found.

    Attributes:
        verdict: `law`, `nothing_to_explain` (only noise is left), or `no_law` (no law of one
            variable earns its place).
        model: the effects that stand beside the curves, with the values that fit with them.
        learned: curves in the order in which they were taken.
        choice_baseline_rad, choice_rmse_rad: RMS errors on the samples that chose.
        report_baseline_rad, report_rmse_rad: on recordings that neither fitted nor chose; None
            without. The baselines are those of the model that is compared with.
        ceilings: what each law alone could explain, on the samples that chose.
        fitted, reported: names of recordings.
    """

    verdict: str
    model: Model
    joints: tuple[str, ...]
    learned: tuple[Learned, ...]
    noise_floor_rad: float
    choice_baseline_rad: float
    choice_rmse_rad: float
    report_baseline_rad: float | None
    report_rmse_rad: float | None
    ceilings: tuple[Ceiling, ...]
    fitted: tuple[str, ...]
    reported: tuple[str, ...]

    @property
    def with_curves(self) -> Model:
        """The model with all curves."""
        return self.with_some([one.curve.law for one in self.learned])

    def without(self, one: Learned) -> Model:
        """The model with all curves but one."""
        return self.with_some([other.curve.law for other in self.learned if other is not one])

    def with_some(self, laws: Sequence[Law]) -> Model:
        """The model with the curves of some laws."""
        curves = (one.curve for one in self.learned if one.curve.law in laws)
        return replace(self.model, learned=(*self.model.learned, *curves))


def propose(
    model: Model,
    predictor: Predictor,
    report: Predictor | None = None,
    masks: tuple[np.ndarray, np.ndarray] | None = None,
    progress: Progress = lambda what, fraction: None,
) -> Proposal:
    """Learn what `model` leaves of the recordings.

    Args:
        predictor: of the recordings to fit and to choose by.
        report: of recordings that do neither.
        masks: (nsample,) bool of `predictor`, samples to fit and samples to choose by; by default
            blocks of time.

    Raises:
        DivergenceError: a simulation of the model runs away.
    """
    fitted, chosen = masks or split(predictor)
    others = report.recordings if report else ()
    model = sized(model, predictor)
    found = search(model, LearningSamples(predictor, fitted, chosen, others), progress)
    return finished(model, found, predictor, report, fitted | chosen)


def finished(
    model: Model,
    found: Search,
    predictor: Predictor,
    report: Predictor | None,
    mask: np.ndarray,
    report_mask: np.ndarray | None = None,
    others: Sequence[Predictor] = (),
) -> Proposal:
    """The laws of a search fitted to all samples of `mask`, with bands, and reported.

    Args:
        model: to compare with.
        report_mask: (nsample,) bool of `report`, the samples that report; by default all.
        others: of further recordings that formulas will be simulated on.
    """
    learned, changed = [], model
    if found.laws:
        state = State(found.state.layout, found.state.u, found.state.laws)
        (last,) = refit([state], predictor, mask, iterations=2)
        rows, jacobian = state.rows(), last.jacobian[: mask.sum()]
        everywhere = seen([predictor, *others])
        anchor = anchoring(state.layout, found.laws, jacobian)
        state.u = anchor @ state.u
        for effect in found.laws:
            weights = state.u[weights_in(state.layout, effect)]
            curve = tabulated(effect, weights, state.u[rest_in(state.layout, effect)])
            ends = band(last, effect, rows, predictor.samples, mask, anchor)
            learned.append(Learned(curve, *ends, everywhere.get(effect.law)))
        names = {effect.name for effect in found.laws}
        own = Layout([t for t in state.layout.terms if t.effect.name not in names])
        changed = from_vector(model, own, moved(state.layout, state.u, own), predictor.joints)
    quiet = found.baseline_rad <= AT_THE_FLOOR * found.noise_floor_rad
    verdict = LAW if learned else NOTHING if quiet else NO_LAW
    proposal = Proposal(
        verdict, changed, predictor.joints, tuple(learned), found.noise_floor_rad,
        found.baseline_rad, found.rmse_rad, None, None, tuple(found.ceilings),
        tuple(r.name for r in predictor.recordings), (),
    )  # fmt: skip
    if report is None:
        return proposal
    return replace(
        proposal,
        report_baseline_rad=error_of(model, report, report_mask),
        report_rmse_rad=error_of(proposal.with_curves, report, report_mask),
        reported=tuple(r.name for r in report.recordings),
    )


def error_of(model: Model, predictor: Predictor, mask: np.ndarray | None = None) -> float:
    """RMS error in rad of a model on recordings."""
    layout, u = model.vector(predictor.joints)
    q = predictor.predict([Request(layout, u[None])])[0][0]
    left = (q - predictor.samples.q)[slice(None) if mask is None else mask]
    return float(np.sqrt(np.mean(left**2)))


def pooled_error(model: Model, sets: Sequence[tuple[Predictor, np.ndarray]]) -> float:
    """RMS error in rad of a model on samples of several predictors, given by their masks."""
    errors = [error_of(model, *each) for each in sets]
    return float(np.sqrt(np.average(np.square(errors), weights=[mask.sum() for _, mask in sets])))
