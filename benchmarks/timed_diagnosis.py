"""A script for `benchmarks.earlier`: the seconds of a diagnosis by whatever t2l is imported.

Only what both revisions have is used.
"""

import sys
import time
from collections.abc import Sequence
from pathlib import Path

from t2l.diagnose.evidence import gather

from t2l.diagnose.ranking import diagnose
from t2l.diagnose.recordings_and_model import read_recordings_and_model
from t2l.effects.registry import builtin


def said(what: str, effects: Sequence[str]) -> str:
    """Names of the known effects; or the processor's seconds of the diagnosis of a recording."""
    if what == "names":
        return " ".join(builtin())
    model, measured, _ = read_recordings_and_model([Path(what)])
    tried = [builtin()[name] for name in effects] or None
    evidence = gather(model.robot, measured, threads=1)
    began = time.process_time()
    diagnose(model, evidence, tried)
    return str(time.process_time() - began)


if __name__ == "__main__":
    print(said(sys.argv[1], sys.argv[2:]))
