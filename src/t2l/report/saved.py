"""Files that a reader may save from the page, which holds them."""

import json
from dataclasses import dataclass
from typing import Any

from t2l.diagnose.files import COMPARISON, DIAGNOSIS, EXPLANATION, MODEL, PROPOSAL
from t2l.diagnose.results import Found


@dataclass(frozen=True)
class Saved:
    """A file in the page: `what` says in a phrase what it holds."""

    name: str
    what: str
    text: str


def saved(found: Found) -> list[Saved]:
    """The results that the page tells of, as they lie in its folder."""
    kept = []
    if found.model_yaml is not None:
        kept.append(
            Saved(
                MODEL,
                "the final model; its robot is found from the folder of this page",
                found.model_yaml,
            )
        )
    if found.explanation is not None:
        what = "every step, what was compared in it, and the parameters of the final model"
        kept.append(_json(EXPLANATION, what, found.explanation))
    elif found.diagnosis is not None:
        what = "every known effect with its parameters, and how each was judged"
        kept.append(_json(DIAGNOSIS, what, found.diagnosis))
    elif found.compared:
        what = "errors by recording, joint and pair of gains"
        kept.append(_json(COMPARISON, what, found.compared[0].numbers))
    if found.proposal is not None:
        kept.append(_json(PROPOSAL, "learned curves with their bands", found.proposal))
    return kept


def _json(name: str, what: str, content: dict[str, Any]) -> Saved:
    return Saved(name, what, json.dumps(content, indent=2, ensure_ascii=False) + "\n")
