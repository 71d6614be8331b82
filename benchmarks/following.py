"""How closely real machines follow their commands: lag, ω_n, ζ and class of each joint.

`python -m benchmarks following --data FOLDER` writes docs/data/following.csv, one row a joint and
pair of gains; it is what `t2l gains` finds. FOLDER is a machine's or holds several, as of
`python -m benchmarks machines`; it may be repeated. Rows of other machines stay. What is documented
of each is in following.yaml beside this file. `t2l.response.following` says what is close.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import yaml

from benchmarks import machines, one_core
from benchmarks.scene import ROOT
from t2l.artefacts import write_text
from t2l.response.following import joint_follows_closely
from t2l.response.joints import JointResponse, responses
from t2l.response.motions import read_motions

DOCUMENTED = ROOT / "benchmarks/following.yaml"
TABLE = ROOT / "docs/data/following.csv"
TOLD = {True: "yes", False: "no", None: "not told"}


def main(arguments: Sequence[str]) -> pd.DataFrame:
    """What the command line asks for: the table, which is written too."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks following", description=__doc__)
    folder = "a machine's folder, or one that holds several; may be repeated"
    parser.add_argument("--data", action="append", type=Path, required=True, help=folder)
    parser.add_argument("--out", type=Path, default=TABLE, help="the table's file")
    given = parser.parse_args(arguments)
    table = pd.read_csv(given.out) if given.out.exists() else pd.DataFrame({"dataset": []})
    chosen = machines.chosen(given.data, ())
    for machine, found in zip(chosen, one_core.each(rows, chosen, 1), strict=True):
        others = table[table.dataset != machine.name]
        table = pd.concat([others, pd.DataFrame(found)]).sort_values("dataset", kind="stable")
        write_text(table.to_csv(index=False, float_format="%.4g"), given.out)
        print(f"{machine.name} is written", flush=True)
    return table


def rows(machine: machines.Machine) -> list[dict]:
    """One of each joint and pair of gains.

    Raises:
        SystemExit: nothing is documented of the machine.
    """
    documented = yaml.safe_load(DOCUMENTED.read_text())
    if machine.name not in documented:
        raise SystemExit(
            f"{DOCUMENTED.name}: found no {machine.name}; allowed: {', '.join(documented)}"
        )
    about = documented[machine.name]
    joints, without = about.pop("joints", None), about.pop("without", [])
    folders = [folder for folder in (machine.train, machine.holdout) if folder]
    paths = [
        path for folder in folders for path in sorted(folder.glob("[!.]*.csv"))
        if not any(name in path.stem for name in without)
    ]  # fmt: skip
    return [
        {"dataset": machine.name, **about, **_numbers(response, len(motions.rows))}
        for motions in read_motions(paths, joints)
        for response in responses(motions)
    ]


def _numbers(response: JointResponse, recordings: int) -> dict:
    fit, lag = response.fit, response.lag
    kp, kd = response.logged or (np.nan, np.nan)
    told = fit.moves and bool(np.isfinite(fit.covariance).all())
    omega, zeta = (fit.interval(i) if told else (np.nan, np.nan) for i in (0, 1))
    late = (lag and lag.interval) or (np.nan, np.nan)
    return {
        "kp": kp,
        "kd": kd,
        "joint": response.joint,
        "recordings": recordings,
        "lag_s": lag.seconds if lag else np.nan,
        "lag_low_s": late[0],
        "lag_high_s": late[1],
        "omega_n_rad_s": fit.omega if fit.moves else np.nan,
        "omega_n_low_rad_s": omega[0],
        "omega_n_high_rad_s": omega[1],
        "zeta": fit.zeta if fit.moves else np.nan,
        "zeta_low": zeta[0],
        "zeta_high": zeta[1],
        "delay_s": fit.delay_s,
        "overshoot": response.overshoot.fraction if response.overshoot else np.nan,
        "steps": response.overshoot.steps if response.overshoot else 0,
        "explained": fit.explained,
        "class": response.region.name if told else "",
        "class_certain": told and response.region.certain,
        "follows": TOLD[joint_follows_closely(response)],
    }
