"""What a log cannot tell, said before the first effect is named."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from t2l.diagnose.confounded import Confounded
from t2l.identify.model import Model
from t2l.recordings.recording import Recording

if TYPE_CHECKING:
    import numpy as np

    from t2l.identify.prediction import Predictor

ENTRY = "identifiability.json"
MOST_SAID = 8  # lines; the file has all


def say_what_cannot_be_told(model: Model, recordings: Sequence[Recording], out: Path) -> None:
    """Print what the recordings' own commands cannot tell, and write all of it into a folder."""
    from t2l.design.artefacts import write_beforehand
    from t2l.design.identifiability import of_log

    told = of_log(model, recordings)
    write_beforehand(told, out)
    sentences = told.sentences("This log")
    for sentence in sentences[:MOST_SAID]:
        print(sentence, flush=True)
    if len(sentences) > MOST_SAID:
        print(f"and {len(sentences) - MOST_SAID} more, see {out / ENTRY}", flush=True)


def say_what_is_confounded(
    model: Model, predictor: "Predictor", mask: "np.ndarray"
) -> list[Confounded]:
    """Print which effects the samples of `mask` (nsample,) do not tell apart; returns them."""
    from t2l.diagnose.confounded import sentences
    from t2l.diagnose.confounding import confounded_beforehand

    found = confounded_beforehand(model, predictor, mask)
    for sentence in sentences(found, model.known_effects(), predictor.recordings):
        print(sentence, flush=True)
    return found
