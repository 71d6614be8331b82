"""A script for `benchmarks.earlier`: the seconds of a diagnosis by whatever t2l is imported.

Only what both revisions have is used, but for the diagnosis itself.
"""

import sys
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from t2l.diagnose.recordings_and_model import read_recordings_and_model
from t2l.effects.registry import builtin

try:
    from t2l.detective.data_split import split
    from t2l.detective.ranking import diagnose

    takes_effects = False
except ImportError:
    from t2l.diagnose import evidence, ranking

    split, diagnose, takes_effects = evidence.gather, ranking.diagnose, True


def said(what: str, effects: Sequence[str]) -> str:
    """Names of the known effects; or the processor's seconds of the diagnosis of a recording."""
    if what == "names":
        return " ".join(builtin())
    model, measured, _ = read_recordings_and_model([Path(what)])
    tried = []
    if effects and takes_effects:
        tried = [[builtin()[name] for name in effects]]
    elif effects:
        model = replace(model, without=tuple(set(builtin()) - set(effects)))
    data = split(model.robot, measured, threads=1)
    began = time.process_time()
    diagnose(model, data, *tried)
    return str(time.process_time() - began)


if __name__ == "__main__":
    print(said(sys.argv[1], sys.argv[2:]))
