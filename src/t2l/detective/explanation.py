"""What the search found, as the explanation that files and pages are written from."""

import hashlib
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import takewhile
from pathlib import Path

import numpy as np

from t2l.design.collinearity import Rival
from t2l.detective.data_split import DataSplit
from t2l.detective.fitted_set import FittedSet
from t2l.detective.kept import fitted_before, keep_fitted, keep_step
from t2l.detective.learned import final_model, proposal_of, splines
from t2l.detective.rule import Judge
from t2l.detective.search import (
    DONE,
    FINISH,
    FIT,
    GROW,
    PRUNE,
    SCREEN,
    Found,
    Named,
    Offered,
    Round,
    more_than,
    search,
)
from t2l.diagnose.confounded import Confounded, sentences
from t2l.diagnose.explanation import Explanation, Step, Tried, write_explanation
from t2l.diagnose.files import PROPOSED
from t2l.diagnose.final_parameters import parameters_of
from t2l.diagnose.fingerprint import fingerprint_of
from t2l.diagnose.ranking import MISSING, NOTHING_MISSING, UNEXPLAINED
from t2l.diagnose.settings import CERTAIN
from t2l.effects.term import Term
from t2l.identify.levels import PROMISING
from t2l.identify.model import Model
from t2l.identify.prediction import Request
from t2l.identify.progress import Progress, pieces
from t2l.names import listed
from t2l.propose.artefacts import write_proposal
from t2l.propose.proposal import Proposal

TOLD = 12  # format: sets that were compared in a round, of those that were not simulated
MOST = 0.99  # format: share of an error that is told as a number
GOES_ON = "The search goes on."
STEP_LEFT = 0.75  # format: of what growing takes, what is left after a step of it


def explained(
    model: Model,
    data: DataSplit,
    tell: Callable[[str], None] = lambda what: None,
    progress: Progress = lambda what, fraction: None,
    spent: Callable[[], float] = lambda: 0.0,
    folder: Path | None = None,
    written: Callable[[], None] = lambda: None,
    began: float | None = None,
) -> Explanation:
    """Names of what `model` lacks, with the errors before and after.

    Args:
        tell: told the first answer, and what is adopted.
        progress: told what is being tried, and how good the best is.
        spent: share of the time that is gone: at 1 no new work begins.
        folder: receives explanation.json, model.yaml and steps/ after each round, from which the
            same search goes on if it was interrupted.
        written: called whenever that is.
        began: of the monotonic clock, from when times are told; now if None.

    Raises:
        DivergenceError: the simulation of the model runs away.
    """
    story = _Story(model, data, tell, progress, folder, written, began)
    found = search(model, data, story.looked, spent, story.resumed)
    explanation = story.ended(found)
    if folder is not None:
        story.write(explanation)
        if splines(found.last):
            story.propose(found)
        written()
    return explanation


def proposed(
    model: Model, data: DataSplit, progress: Progress = lambda what, fraction: None
) -> Proposal:
    """Curves that `model` lacks, where no known effect is offered.

    Raises:
        DivergenceError: the simulation of the model runs away.
    """
    story = _Story(model, data, lambda said: None, progress, None, lambda: None, None)
    found = search(model, data, story.looked, offered=Offered(names=False))
    return proposal_of(model, found, data, story.quiet(found))


class _Story:
    """The steps so far, in words and in files."""

    def __init__(self, model: Model, data: DataSplit, tell, progress, folder, written, began):
        self.model, self.data, self.folder = model, data, folder
        self.tell, self.progress, self.written = tell, progress, written
        self.began = time.monotonic() if began is None else began
        self.joints = data.fitted.joints
        came = model.terms(self.joints)
        self.known = model.known_effects() | {term.effect.name: term.effect for term in came}
        self.came = {term.effect.name: term.joints for term in came}
        self.steps: list[Step] = []
        self.rounds = 0
        self.resumed: tuple[int, FittedSet] | None = None
        self.parts: Iterator[Progress] = pieces(progress)
        if folder is not None:
            self.key = fingerprint_of(model, _shared_out(data), (data.fitted, data.test))
            before = fitted_before(folder, self.key, model, self.joints)
            if before is not None:
                self.steps, self.rounds, last = before
                self.resumed = self.rounds, last
                self.tell(f"Going on after step {len(self.steps) - 1}, kept in {folder}.")

    def looked(self, this: Round) -> None:
        """Say what a round does next, or what it adopted; that is a step."""
        self.known |= this.effects
        if not self.steps:
            self.steps = [self._step(this.before)]
        if this.adopted is not None:
            self._grown(this)
            return
        if this.doing == SCREEN:
            self.part = next(self.parts)
            self.rounds += 1
        if this.doing == FIT and this.front and self.rounds == 1:
            self.tell(f"After {self.seconds:.0f} s, most likely: {self._promised(this)}.")
        if this.front or this.doing == SCREEN:
            self.part(f"round {self.rounds}: {_doing(this)}; {_best(this)}", _done(this))

    def ended(self, found: Found) -> Explanation:
        """The explanation at the end of the search."""
        last = found.rounds[-1]
        self.known |= last.effects
        if not self.steps:
            self.steps = [self._step(last.before)]
        one, noise = last.adopted or last.before, last.noise_rad
        quiet = Judge(np.zeros(0), noise).quiet(one.rmse, len(self.steps) == 1)
        verdict = NOTHING_MISSING if quiet else UNEXPLAINED
        model = final_model(self.model, found.last, self.joints)
        seconds = None
        if found.stopped:
            seconds, verdict = self.seconds, MISSING
        sentence = self._sentence(one, noise, verdict)
        if found.stopped:
            sentence += f" {self._stopped(last)}"
        elif verdict == UNEXPLAINED:
            sentence += self._only_promised(found)
        nothing_more = () if last.adopted else self._tried(last)
        ties = self._ties(last, found.last)
        said = sentences(ties, self.known, self.data.fitted.recordings)
        return Explanation(
            self.steps, verdict, noise, " ".join([sentence, *said]), model,
            stopped_after_s=seconds, confounded=ties, then_tried=nothing_more,
        )  # fmt: skip

    def _ties(self, last: Round, model: FittedSet) -> tuple[Confounded, ...]:
        """Adopted effects in whose place others explain as well."""
        found: dict[str, dict[tuple[str, ...], Rival]] = {}
        for tie in sorted(last.ties, key=lambda f: f.left_out_rmse):
            own, other = ({name for name, _ in one.names} for one in (model, tie))
            gone, new = sorted(own - other), sorted(other - own)
            # of what came with the model nobody asks
            if len(gone) == 1 and new and gone[0] not in self.came:
                names = tuple(new)
                rival = Rival(names, None, tie.left_out_rmse)
                found.setdefault(gone[0], {}).setdefault(names, rival)
        return tuple(Confounded(name, tuple(some.values())) for name, some in found.items())

    def propose(self, found: Found) -> None:
        """Write the curves with their bands and formulas."""
        self.progress("drawing the curves and looking for formulas", MOST)
        proposal = proposal_of(self.model, found, self.data, self.quiet(found))
        judged = [(self.data.fitted, self.data.fitted_mask)]
        test = self.data.test
        write_proposal(
            proposal, self.folder / PROPOSED, judged, test, report_mask=self.data.test_mask
        )

    def quiet(self, found: Found) -> bool:
        """Whether the model as it came leaves only noise."""
        first = found.rounds[0]
        return Judge(np.zeros(0), first.noise_rad).quiet(first.before.rmse, True)

    def write(self, explanation: Explanation) -> None:
        """Into the folder."""
        rows = parameters_of(explanation.model, self.data.fitted, self.data.fitted_mask)
        if len(explanation.steps) == 1 or not explanation.final:
            keep_step(explanation, rows, self.model, self.folder)
        else:
            write_explanation(explanation, self.folder, rows)

    @property
    def seconds(self) -> float:
        """Since the run began."""
        return time.monotonic() - self.began

    def _grown(self, this: Round) -> None:
        one = this.adopted
        gone = {name for name, _ in this.before.names} - {name for name, _ in one.names}
        step = self._step(one)
        self.steps.append(
            replace(
                step,
                effects=tuple(this.added),
                dropped=tuple(sorted(gone)),
                titles=tuple(self._titles(this.added.items())),
                chosen_shares=tuple(this.shares.get(name) for name in this.added),
                tried=self._tried(this),
            )
        )
        self.tell(
            f"After {self.seconds:.0f} s, fitted: {self._words(this.added.items())}; the error on "
            f"what was left out goes from {_mrad(this.before.left_out_rmse)} to "
            f"{_mrad(one.left_out_rmse)} mrad."
        )
        if self.folder is None:
            return
        model = final_model(self.model, one, self.joints)
        sentence = f"{self._sentence(one, this.noise_rad)} {GOES_ON}"
        self.write(Explanation(self.steps, MISSING, this.noise_rad, sentence, model, final=False))
        # a quiet round is the last: who goes on does it again, and ends as it did
        if not this.quiet:
            keep_fitted(self.folder, self.key, self.steps, self.rounds, one)
        self.written()

    def _step(self, one: FittedSet) -> Step:
        test = self.data.test
        q = test.predict([Request(one.layout, one.u[None])])[0][0]
        left = float(np.sqrt(np.mean((q - test.samples.q)[self.data.test_mask] ** 2)))
        return Step((), one.rmse, one.left_out_rmse, left)

    def _tried(self, this: Round) -> tuple[Tried, ...]:
        """What a round compared: all that was simulated, and the best of the rest."""
        led = sorted(this.led, key=lambda f: f.left_out_rmse)[:TOLD]
        had = this.before.names
        return tuple(
            Tried(
                tuple(self._titles(more_than(had, one.names).items())),
                one.complexity, one.left_out_rmse, simulated,
            )
            for some, simulated in ((this.fits, True), (led, False))
            for one in some
        )  # fmt: skip

    def _titles(self, names: Named) -> list[str]:
        return [Term(self.known[name], on).title(self.joints) for name, on in names]

    def _words(self, names: Named) -> str:
        return listed(self._titles(names)) or "fewer effects"

    def _promised(self, this: Round) -> str:
        """The best by the linear model: fitted along the motion, or else of the screen."""
        if this.likely is not None:
            names = more_than(this.before.names, this.likely.names).items()
            error, before = this.likely.left_out_rmse, this.before.left_out_rmse
        else:
            _, error, names = this.front[_simplest(this)]
            before = this.before.rmse
        share = max(0.0, 1 - (error / before) ** 2)
        # whole percents would say that nothing is left
        said = f"{100 * share:.0f}" if share < MOST else f"over {100 * MOST:.0f}"
        return (
            f"{self._words(names)}; the linear model of the loop says that this explains "
            f"{said} % of the squared error"
        )

    def _sentence(self, one: FittedSet, noise_rad: float, verdict: str | None = None) -> str:
        """What was adopted before whether more is missing."""
        first, last = (_mrad(step.test_rmse_rad) for step in (self.steps[0], self.steps[-1]))
        noise = f"noise {_mrad(noise_rad)} mrad"
        names = (
            self._words(more_than(self.came.items(), one.names).items())
            if len(self.steps) > 1
            else ""
        )
        more = {
            NOTHING_MISSING: " Nothing more is missing.",
            UNEXPLAINED: " More is missing, which no known effect and no curve explains.",
        }.get(verdict, "")
        if names:
            return (
                f"The model lacks {names}: the test error goes from {first} to {last} mrad "
                f"({noise}).{more}"
            )
        if verdict == NOTHING_MISSING:
            return f"No effect is missing: the test error of {last} mrad is near the {noise}."
        if verdict == UNEXPLAINED:
            return (
                "Unexplained: no known effect and no curve removes the test error of "
                f"{last} mrad ({noise})."
            )
        return f"Nothing is adopted: the test error is {last} mrad ({noise})."

    def _only_promised(self, found: Found) -> str:
        """What the linear model promises and no simulation confirms."""
        open_ones = list(takewhile(lambda r: r.adopted is None, reversed(found.rounds)))
        promised = next((r for r in open_ones if r.promised is not None), None)
        if promised is None:
            return ""
        names = more_than(promised.before.names, promised.promised.names).items()
        return (
            f" Along the measured motion {self._words(names)} would leave "
            f"{_mrad(promised.promised.left_out_rmse)} mrad, but a simulation with that does not "
            "follow the recordings."
        )

    def _stopped(self, last: Round) -> str:
        """What a search that ran out of time had in its hands."""
        said = f"The search was stopped by --time after {self.seconds:.0f} s; more may be missing"
        if last.fits and last.fits[0].left_out_rmse < last.before.left_out_rmse:
            best = last.fits[0]
            names = self._words(more_than(last.before.names, best.names).items())
            return (
                f"{said}, most likely {names}: fitted, the error on what was left out would go "
                f"from {_mrad(last.before.left_out_rmse)} to {_mrad(best.left_out_rmse)} mrad."
            )
        if last.front:
            return f"{said}, most likely {self._promised(last)}."
        return f"{said}."


def in_words(explanation: Explanation) -> list[str]:
    """The steps and the answer, a line each."""
    lines = []
    for number, step in enumerate(explanation.steps):
        what = listed(step.titles) or ("fewer effects" if number else "model as it came")
        lines.append(
            f"{what:41s} training {1e3 * step.train_rmse_rad:8.4g} mrad, "
            f"test {1e3 * step.test_rmse_rad:8.4g}{_sure(step)}"
        )
    return [*lines, explanation.sentence]


def _sure(step: Step) -> str:
    told = [
        both for both in zip(step.titles, step.chosen_shares, strict=True) if both[1] is not None
    ]
    if not told:
        return ""
    unsure = [title for title, share in told if share < CERTAIN]
    which = f": {listed(unsure)}" if len(told) > 1 else ""
    shares = listed([f"{100 * share:.0f}" for _, share in told])
    return f", chosen in {shares} % of resamples{f', uncertain{which}' if unsure else ''}"


def _simplest(this: Round) -> int:
    """Of the front, the set of fewest numbers that a fit may make as good as the best."""
    least = min(error for _, error, _ in this.front)
    near = [i for i, (_, error, _) in enumerate(this.front) if error <= PROMISING * least]
    return min(near, key=lambda i: this.front[i][:2])


def _doing(this: Round) -> str:
    return {
        SCREEN: "screening effects and curves in the linear model"
        if not this.quiet
        else "looking for other effects that explain as well",
        FIT: f"fitting {len(this.front)} sets of effects",
        FINISH: f"finishing the best of {len(this.fits)} fits",
        GROW: "adding effects to the best sets" + _grown(this),
        PRUNE: "dropping what is not needed",
    }[this.doing]


def _grown(this: Round) -> str:
    if not this.grown:
        return ""
    best = this.grown[-1]
    return (
        f", with {len(best.layout.terms)} effects {_mrad(best.left_out_rmse)} mrad by the linear "
        "model of the loop"
    )


def _done(this: Round) -> float:
    """Which part of a round is done; each step of growing takes a part of what is left."""
    if this.doing != GROW:
        return DONE[this.doing]
    return DONE[PRUNE] - (DONE[PRUNE] - DONE[GROW]) * STEP_LEFT ** len(this.grown)


def _best(this: Round) -> str:
    errors = [one.left_out_rmse for one in (this.before, *this.fits[:1])]
    return f"best so far {_mrad(min(errors))} mrad (noise {_mrad(this.noise_rad)})"


def _mrad(rad: float) -> str:
    return f"{1e3 * rad:.3g}"


def _shared_out(data: DataSplit) -> str:
    """Which sample is in which part and fold."""
    parts = (data.fitted_mask, data.test_mask, data.folds)
    return hashlib.sha256(b"".join(part.tobytes() for part in parts)).hexdigest()
