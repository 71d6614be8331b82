"""Scoreboard, tables and figures of the documentation are one job, which trains nothing."""

import shutil

import pandas as pd
import pytest

from t2l.figures.kept import FIGURES
from t2l.report.kept import PAGES
from t2l.study.published.numbers import claims
from tests.conftest import ROOT


@pytest.fixture
def documented(empty_project):
    """With the documentation and what it keeps."""
    shutil.copytree(ROOT / "docs", empty_project.folder / "docs")
    shutil.copy(ROOT / "README.md", empty_project.folder)
    return empty_project


def test_it_is_one_job_that_reads_all_that_is_kept(documented):
    done = documented.run_default("--dry-run", "--", "published")
    assert done.returncode == 0, done.stdout
    assert "published" in done.stdout
    assert not any(rule in done.stdout for rule in ("train", "roll_out", "record_motion"))
    read = [*PAGES, *(f"docs/data/{path.name}" for path in ROOT.glob("docs/data/*.csv"))]
    assert all(name in done.stdout for name in read)


@pytest.mark.slow
def test_it_writes_what_is_committed(documented):
    done = documented.run_default("--", "published")
    assert done.returncode == 0, done.stdout
    made = documented.folder / "results/published"
    for name in PAGES:
        assert (made / "pages" / name).read_text() == (ROOT / name).read_text()
    assert {path.stem for path in (made / "figures").glob("*.png")} == set(FIGURES)
    assert len(pd.read_csv(made / "scoreboard.csv")) == len(claims())
    assert (made / "findings.md").exists()
