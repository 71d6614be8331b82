"""Planted tables come out each way: a trend is found, so is its absence, few cells cannot tell."""

import numpy as np

from tests.study.judged import NO, YES, verdict
from tests.study.planted import TRANSFER, frame


def _identified(factor, rest=1.0):
    error = {"SO": 1e-5 / factor, "CO": 1e-5 * rest, "CU": 1e-5, "SU": 1e-5}

    def planted(kp, kd, region):
        return error[region] * (1 + 0.01 * np.sin(kp + 3 * kd))

    return {"sim_to_real__identification": frame(TRANSFER, "transfer", s_star=planted)}


def test_identification():
    assert verdict("identification_so_lowest", **_identified(2)) is YES
    assert verdict("identification_so_lowest", **_identified(0.5)) is NO
    assert verdict("identification_factor", **_identified(20)) is YES
    assert verdict("identification_factor", **_identified(3)) is NO
    assert verdict("identification_co_highest", **_identified(2, rest=5)) is YES
    assert verdict("identification_co_highest", **_identified(2, rest=0.1)) is not YES
