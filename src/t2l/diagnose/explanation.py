"""What a search found, step by step, and the files that hold it."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from t2l.artefacts import write_text
from t2l.diagnose import confounded
from t2l.diagnose.confounded import Confounded
from t2l.diagnose.files import EXPLANATION, MODEL
from t2l.identify.model import Model, write_model


@dataclass(frozen=True)
class Tried:
    """A set of effects and curves that was compared with others.

    Attributes:
        titles: of what it has more than the model had; none if it has less.
        numbers: that it fits, and names.
        simulated: or fitted along the measured motion only, by the linear model of the loop.
    """

    titles: tuple[str, ...]
    numbers: int
    left_out_rmse_rad: float
    simulated: bool


@dataclass(frozen=True)
class Step:
    """A model on the way, and what it has more than the one before.

    Attributes:
        effects: names of what was added, none for the model as it came.
        dropped: effects that these made superfluous.
        titles: of `effects`, each with the joints that it was added on if these are not all.
        chosen_shares: of `effects`, how often each was selected over resamples; None where that
            cannot be told.
        tried: what was compared in the round that led to it.
    """

    effects: tuple[str, ...]
    train_rmse_rad: float
    validation_rmse_rad: float
    test_rmse_rad: float
    dropped: tuple[str, ...] = ()
    titles: tuple[str, ...] = ()
    chosen_shares: tuple[float | None, ...] = ()
    tried: tuple[Tried, ...] = ()

    @property
    def chosen_share(self) -> float | None:
        """Of the least sure of its effects."""
        return min((share for share in self.chosen_shares if share is not None), default=None)


@dataclass(frozen=True)
class Explanation:
    """The steps, where they ended, and the final model.

    `confounded` are names found that cannot be told from others. A search that still goes on is not
    `final`; one that ran out of time was stopped after so many seconds. `then_tried` is what the
    last round compared, of which it adopted nothing.
    """

    steps: list[Step]
    verdict: str
    noise_floor_rad: float
    sentence: str
    model: Model
    confounded: tuple[Confounded, ...] = ()
    final: bool = True
    stopped_after_s: float | None = None
    then_tried: tuple[Tried, ...] = ()


def as_json(explanation: Explanation) -> dict:
    """What `explanation.json` holds."""
    return {
        "steps": [
            {
                "effects": list(step.effects),
                "titles": list(step.titles),
                "train_rmse_q_rad": step.train_rmse_rad,
                "validation_rmse_q_rad": step.validation_rmse_rad,
                "test_rmse_q_rad": step.test_rmse_rad,
                "dropped": list(step.dropped),
                "chosen_share": step.chosen_share,
                "chosen_shares": list(step.chosen_shares),
                "tried": [_tried(one) for one in step.tried],
            }
            for step in explanation.steps
        ],
        "then_tried": [_tried(one) for one in explanation.then_tried],
        "final": explanation.final,
        "stopped_after_s": explanation.stopped_after_s,
        "verdict": explanation.verdict,
        "sentence": explanation.sentence,
        "noise_floor_rad": explanation.noise_floor_rad,
        "confounded": confounded.as_json(explanation.confounded),
    }


def _tried(one: Tried) -> dict:
    return {
        "titles": list(one.titles),
        "numbers": one.numbers,
        "left_out_rmse_q_rad": one.left_out_rmse_rad,
        "simulated": one.simulated,
    }


def write_explanation(
    explanation: Explanation, folder: Path, parameters: Sequence[dict[str, Any]] = ()
) -> None:
    """Write `explanation.json` and `model.yaml`.

    Args:
        parameters: of the final model, as `t2l.diagnose.final_parameters` finds them.
    """
    stand = explanation.model.effects
    found = [name for step in explanation.steps for name in step.effects if name in stand]
    names = [*dict.fromkeys(found), *(curve.law.words for curve in explanation.model.learned)]
    comment = f"made by t2l explain; adopted: {', '.join(names) or 'nothing'}"
    write_model(explanation.model, folder / MODEL, comment)
    content = as_json(explanation) | {"parameters": list(parameters)}
    write_text(json.dumps(content, indent=2) + "\n", folder / EXPLANATION)
