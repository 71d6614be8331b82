"""The study's published grids, where they are beside the project, in the layout of its page."""

import json

from t2l.study.published.grids import read_grids
from tests.conftest import ROOT

STUDY = ROOT.parent / "shared" / "data" / "paper_results.json"


def published_grids(folder):
    """As `read_grids` reads them from the page's file, which is written to a folder."""
    tasks = json.loads(STUDY.read_text())["bc_success"]
    page = {
        name: {
            "kps": t["kps"], "kds": t["kds"], "validation": t["success"], "replay": t["replay"],
            "loss": t["final_loss"],
        }
        for name, t in tasks.items() if isinstance(t, dict)
    }  # fmt: skip
    path = folder / "page.json"
    path.write_text(json.dumps({"taskData": page}))
    return read_grids(path)
