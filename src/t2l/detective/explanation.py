"""What the search found, as the explanation that files and pages are written from."""

import os
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from t2l.detective.data_split import DataSplit
from t2l.detective.fit import FittedSet
from t2l.detective.search import Round, search
from t2l.diagnose.forward_selection import Explanation, Step
from t2l.diagnose.ranking import NEAR_THE_FLOOR, NOTHING_MISSING, UNEXPLAINED
from t2l.errors import ConfigurationError
from t2l.identify.levels import AT_THE_FLOOR
from t2l.identify.model import Model
from t2l.identify.prediction import Request
from t2l.names import listed


def check_no_steps(folder: Path) -> None:
    """Find the steps of a whole run in a folder, which a quick one would not belong to.

    Raises:
        ConfigurationError: there are some.
    """
    if os.path.lexists(folder / "steps"):
        raise ConfigurationError(
            f"--quick: found the steps of a whole run in {folder}; allowed: another folder as --out"
        )


def explained_quickly(
    model: Model, data: DataSplit, tell: Callable[[str], None] = lambda what: None
) -> Explanation:
    """Names of what `model` lacks, with the errors before and after.

    Args:
        tell: told the first answer, and what is adopted.
    """
    began = time.monotonic()
    joints = data.fitted.joints
    titles = {name: effect.title for name, effect in model.known_effects().items()}

    def words(names: Sequence[tuple[str, tuple[int, ...]]]) -> str:
        return listed([_on(titles[name], on, joints) for name, on in names])

    def looked(this: Round) -> None:
        seconds = time.monotonic() - began
        if this.adopted is None and this.front:
            error, names = this.front[0][1], this.front[0][2]
            before = this.before.rmse
            share = max(0.0, 1 - (error / before) ** 2)
            tell(
                f"After {seconds:.0f} s, most likely: {words(names)}; the linear model of the loop "
                f"says that this explains {100 * share:.0f} % of the squared error."
            )
        elif this.adopted is not None:
            after = 1e3 * this.adopted.left_out_rmse
            had = {name: set(on) for name, on in this.before.names}
            new = sorted(n for n in this.adopted.names if set(n[1]) != had.get(n[0]))
            tell(
                f"After {seconds:.0f} s, fitted: {words(new)}; the error on what was left out goes "
                f"from {1e3 * this.before.left_out_rmse:.3g} to {after:.3g} mrad."
            )

    found = search(model, data, looked=looked)
    sets = [found.rounds[0].before, *(r.adopted for r in found.rounds if r.adopted)]
    steps = []
    for one in sets:
        had = {name: set(on) for name, on in steps[-1][1].names} if steps else {}
        new = [name for name, on in sorted(one.names) if set(on) != had.get(name)]
        gone = sorted(set(had) - {name for name, _ in one.names})
        steps.append((" + ".join(new) if steps else None, one, tuple(gone)))
    whole = [
        Step(effect, one.rmse, one.left_out_rmse, _tested(data, one), dropped)
        for effect, one, dropped in steps
    ]
    last, noise = sets[-1], found.rounds[-1].noise_rad
    near = AT_THE_FLOOR if len(sets) > 1 else NEAR_THE_FLOOR
    verdict = NOTHING_MISSING if last.left_out_rmse <= near * noise else UNEXPLAINED
    sentence = _sentence(verdict, whole, noise, words(sorted(last.names - sets[0].names)))
    return Explanation(whole, verdict, noise, sentence, found.model)


def in_words(explanation: Explanation) -> list[str]:
    """The steps and the answer, a line each."""
    lines = [
        f"{step.effect or 'model as it came':41s} training {1e3 * step.train_rmse_rad:8.4g} mrad, "
        f"test {1e3 * step.test_rmse_rad:8.4g}"
        for step in explanation.steps
    ]
    return [*lines, explanation.sentence]


def _on(title: str, on: Sequence[int], joints: Sequence[str]) -> str:
    return title if len(on) == len(joints) else f"{title} on {listed([joints[j] for j in on])}"


def _tested(data: DataSplit, one: FittedSet) -> float:
    q = data.test.predict([Request(one.layout, one.u[None])])[0][0]
    return float(np.sqrt(np.mean((q - data.test.samples.q)[data.test_mask] ** 2)))


def _sentence(verdict: str, steps: Sequence[Step], noise_rad: float, names: str) -> str:
    """What was adopted before whether more is missing."""
    first, last = (1e3 * step.test_rmse_rad for step in (steps[0], steps[-1]))
    noise = f"noise {1e3 * noise_rad:.3g} mrad"
    more = (
        "Nothing more is missing."
        if verdict == NOTHING_MISSING
        else "More is missing, which no known effect explains."
    )
    if names:
        return (
            f"The model lacks {names}: the test error goes from {first:.3g} to {last:.3g} mrad "
            f"({noise}). {more}"
        )
    if verdict == NOTHING_MISSING:
        return f"No effect is missing: the test error of {last:.3g} mrad is near the {noise}."
    return f"Unexplained: no known effect removes the test error of {last:.3g} mrad ({noise})."
