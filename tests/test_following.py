"""The table of how closely machines follow is what is documented and what their motion shows."""

import pandas as pd
import pytest
import yaml
from benchmarks import following, machines

from tests.conftest import ROOT
from tests.response import made

OMEGA, ZETA = 20.0, 0.8


@pytest.fixture
def folder(tmp_path):
    """A machine whose elbow alone is a known system; its shoulder has no motor."""
    path = tmp_path / "acromonk"
    path.mkdir()
    for name in ("one", "two"):
        time, command, q = made.rows(OMEGA, ZETA, duration_s=20.0, noise=1e-4)
        rows = {"time": time, "q_des.shoulder": q, "q_des.elbow": command,
                "q.shoulder": q, "q.elbow": q}  # fmt: skip
        pd.DataFrame(rows).to_csv(path / f"{name}.csv", index=False)
        about = {"robot": "fr3", "joints": ["shoulder", "elbow"], "kp": [1e-6, 16.0],
                 "kd": [0.0, 0.3], "command_rate_hz": 50, "control_rate_hz": 1000,
                 "gravity_compensation": False}  # fmt: skip
        (path / f"{name}.yaml").write_text(yaml.safe_dump(about))
    return path


def test_a_row_holds_what_is_documented_and_what_is_found(folder):
    (machine,) = machines.chosen([folder], ())
    (row,) = following.rows(machine)
    assert (row["dataset"], row["joint"], row["recordings"]) == ("acromonk", "elbow", 2)
    assert (row["commands"], row["gains"], row["learning"]) == ("made", "one pair", False)
    assert (row["kp"], row["kd"]) == (16.0, 0.3)
    assert row["omega_n_low_rad_s"] < OMEGA < row["omega_n_high_rad_s"]
    assert row["zeta"] == pytest.approx(ZETA, rel=0.05)
    assert row["class"] == "SU"


def test_a_machine_of_which_nothing_is_documented_is_refused(folder):
    other = folder.rename(folder.with_name("nobody_knows"))
    with pytest.raises(SystemExit, match="nobody_knows"):
        following.rows(machines.Machine(other.name, other, None))


def test_what_is_kept_is_documented():
    documented = yaml.safe_load(following.DOCUMENTED.read_text())
    kept = pd.read_csv(ROOT / "docs/data/following.csv")
    assert set(kept.dataset) == set(documented)
    for name, rows in kept.groupby("dataset"):
        for key in ("commands", "gains", "learning", "known"):
            assert (rows[key] == documented[name][key]).all(), (name, key)
