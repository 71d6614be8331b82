"""Effects that recordings cannot tell apart, as sentences and as JSON."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from t2l.design.collinearity import Rival
from t2l.effects.effect import Effect
from t2l.recordings.recording import Recording

MOST_SAID = 3  # format: rivals in a sentence, and partners of one; the file has all


@dataclass(frozen=True)
class Confounded:
    """An effect that the recordings do not tell from others.

    Attributes:
        effect: its name.
        rivals: what it is not told from: single effects first, the most alike first.
        more_missing: whether it leaves more than noise: what else is found may tell.
    """

    effect: str
    rivals: tuple[Rival, ...]
    more_missing: bool = False

    def from_what(self, titles: Mapping[str, str]) -> str:
        """What it is not told from, in words: A; B together with C or D."""
        said = [titles.get(r.effects[0], r.effects[0]) for r in self.rivals if len(r.effects) == 1]
        pairs = [set(r.effects) for r in self.rivals if len(r.effects) == 2]
        while pairs:
            # one partner, named once, beside all that it may go with
            often = Counter(name for pair in pairs for name in sorted(pair))
            first = often.most_common(1)[0][0]
            partners = [(pair - {first}).pop() for pair in pairs if first in pair]
            pairs = [pair for pair in pairs if first not in pair]
            named = [titles.get(name, name) for name in partners[:MOST_SAID]]
            more = len(partners) - len(named)
            named += [f"{more} more"] if more else []
            said.append(f"{titles.get(first, first)} together with {_or(named)}")
        more = len(said) - MOST_SAID
        return "; ".join([*said[:MOST_SAID], *([f"{more} more"] if more > 0 else [])])


def sentences(
    found: Sequence[Confounded], effects: Mapping[str, Effect], recordings: Sequence[Recording]
) -> list[str]:
    """What cannot be told apart, for people; each pair of effects once, and what to do last."""
    titles = {name: effect.title for name, effect in effects.items()}
    said, done = [], set()
    for entry in found:
        # a rival alone is as much a rival the other way round
        rivals = tuple(r for r in entry.rivals if (*r.effects, entry.effect) not in done)
        done |= {(entry.effect, *rival.effects) for rival in rivals}
        if rivals:
            what = Confounded(entry.effect, rivals).from_what(titles)
            said.append(f"These recordings cannot tell {titles[entry.effect]} from {what}.")
    if not said:
        return []
    if any(entry.more_missing for entry in found):
        said.append("This is no error: more is missing than one of these, and what is found first "
                    "may tell them apart.")  # fmt: skip
    if len({(*r.kp, *r.kd) for r in recordings}) == 1:
        said.append("All of them have one pair of gains (Kp, Kd): record others too.")
    # of a plan no optional column is known beforehand
    names = [name for name in members(found) if not effects[name].needs]
    said.append(f"Motions and gains that can: t2l plan CONFIG.yaml --tell {','.join(names)}")
    return said


def members(found: Sequence[Confounded]) -> list[str]:
    """Every effect that is not told from another, once."""
    names = (name for e in found for name in (e.effect, *(n for r in e.rivals for n in r.effects)))
    return list(dict.fromkeys(names))


def as_json(found: Iterable[Confounded]) -> list[dict[str, Any]]:
    """As files hold it."""
    return [
        {
            "effect": entry.effect,
            "not_told_from": [
                {"effects": list(r.effects)}
                | (
                    {"validation_rmse_q_rad": r.error}
                    if r.collinearity is None
                    else {"collinearity": r.collinearity}
                )
                for r in entry.rivals
            ],
        }
        for entry in found
    ]


def _or(words: Sequence[str]) -> str:
    return " or ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)
