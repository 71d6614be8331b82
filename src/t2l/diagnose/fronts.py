"""What each round of a search compared: sets of effects and curves, of few numbers and of more."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import isclose
from typing import Any

from t2l.diagnose.result_types import Tried
from t2l.diagnose.results import Found, label_of, titles_of
from t2l.names import listed


@dataclass(frozen=True)
class Front:
    """A round of a search.

    Attributes:
        step: number of the step that it led to, or would have.
        label: what was adopted.
        tried: sets that were compared, of few numbers first, of as many the better first.
        before_rad: error on what was left out, of the model before it.
        adopted_rad: likewise, of what was adopted; None if nothing was.
        adopted: which of `tried` that is; None too where numbers were dropped from it afterwards.
    """

    step: int
    label: str
    tried: list[Tried]
    before_rad: float
    adopted_rad: float | None = None
    adopted: int | None = None

    @property
    def names(self) -> list[str]:
        """Of each set, what it adds."""
        return [listed(one["titles"]) or "fewer effects" for one in self.tried]

    @property
    def best(self) -> list[int]:
        """Of the simulated sets those that are better than all of fewer numbers."""
        least, best = float("inf"), []
        for place, one in enumerate(self.tried):
            if one["simulated"] and one["left_out_rmse_q_rad"] < least:
                least = one["left_out_rmse_q_rad"]
                best.append(place)
        return best


def fronts(found: Found) -> list[Front]:
    """The rounds of an explanation that compared anything, the one that adopted nothing last."""
    if found.explanation is None:
        return []
    steps, titles = found.explanation["steps"], titles_of(found)
    rounds = [
        _led_to(number, steps[number - 1], step, label_of(step, titles))
        for number, step in enumerate(steps[1:], start=1)
    ]
    before = steps[-1]["validation_rmse_q_rad"]
    last = _in_order(found.explanation["then_tried"])
    rounds.append(Front(len(steps), "nothing adopted", last, before))
    return [one for one in rounds if one.tried]


def _led_to(number: int, before: dict[str, Any], step: dict[str, Any], label: str) -> Front:
    tried, error = _in_order(step["tried"]), step["validation_rmse_q_rad"]
    # by its error: a curve of few numbers has the same title as one of many
    same = (
        place
        for place, one in enumerate(tried)
        if one["simulated"] and isclose(one["left_out_rmse_q_rad"], error)
    )
    return Front(number, label, tried, before["validation_rmse_q_rad"], error, next(same, None))


def _in_order(tried: Sequence[Tried]) -> list[Tried]:
    return sorted(tried, key=lambda one: (one["numbers"], one["left_out_rmse_q_rad"]))
