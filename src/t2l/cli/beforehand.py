"""What a log cannot tell, said before anything is fitted to it."""

from collections.abc import Sequence
from pathlib import Path

from t2l.identify.model import Model
from t2l.recordings.recording import Recording

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
