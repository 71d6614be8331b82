"""Planted tables come out each way: a trend is found, so is its absence, few cells cannot tell."""

import numpy as np
import pandas as pd

from tests.study.judged import CLAIMS, NO, OPEN, YES, verdict
from tests.study.planted import evidence


def test_stiffness_is_not_the_gain():
    def stiffness(ratio, seeds=3, drift=0.02, success=0.9):
        rows = [
            (kp, seed, base * (1 + 0.05 * seed))
            for kp, base in ((16, 100.0 * ratio), (512, 100.0))
            for seed in range(seeds)
        ]
        table = pd.DataFrame(rows, columns=["kp", "seed", "stiffness_n_m"])
        table = table.assign(pairing=table.kp.astype(str), drift=drift, success=success)
        return {"decoupling__trainings": table}

    assert verdict("stiff_behaviour", **stiffness(5)) is YES
    assert verdict("stiff_behaviour", **stiffness(0.5)) is NO
    assert verdict("stiff_behaviour", **stiffness(5, seeds=2)) is OPEN
    assert verdict("stiffness_ratio", **stiffness(5)) is YES
    assert verdict("stiffness_ratio", **stiffness(32)) is NO
    found = CLAIMS["stiffness_ratio"].finding(evidence(**stiffness(5)))
    assert found.ours.startswith("5.0 times (4.")
    assert found.lower < 5 < found.upper
    # policies that seldom hold the pose, or a tool that goes on, show no stiffness
    for key in ("stiff_behaviour", "stiffness_ratio"):
        assert verdict(key, **stiffness(5, success=0.4)) is OPEN
        assert verdict(key, **stiffness(5, drift=1.6)) is OPEN
        # nor do policies of which it is not known
        assert verdict(key, **stiffness(5, success=np.nan)) is OPEN
    found = CLAIMS["stiff_behaviour"].finding(evidence(**stiffness(5, drift=1.6)))
    assert found.ours.endswith("of 6 policies 0 yield steadily, 6 hold the pose")
    found = CLAIMS["stiff_behaviour"].finding(evidence(**stiffness(5, drift=1.6, success=np.nan)))
    assert found.ours.endswith("of 6 policies 0 yield steadily")
