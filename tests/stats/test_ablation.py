import pandas as pd
import pytest

from t2l.gains import Cell
from t2l.stats.ablation import WHOLE, ablation_table, by_cell, printable_ablation

STIFF = [Cell(kp, kd) for kp in (128, 512) for kd in (8, 24)]
INSIDE = dict.fromkeys(STIFF, True) | {Cell(16, 2): False}


def rollouts(shaking):
    """Two policies of two rollouts in each cell, of which so many shake."""
    rows = [
        (cell.kp, cell.kd, seed, 0.1, number < shaking[cell], False)
        for cell in INSIDE for seed in (1, 2) for number in (2 * seed - 2, 2 * seed - 1)
    ]  # fmt: skip
    names = ["kp", "kd", "seed", "trajectory_error", "jitter_failure", "jitter_failure_sim"]
    return pd.DataFrame(rows, columns=names)


def test_what_an_effect_does_is_what_goes_with_it():
    soft = {Cell(16, 2): 1}
    cells = by_cell(
        {
            WHOLE: rollouts(dict(zip(STIFF, [4, 2, 4, 2], strict=True)) | soft),
            "latency": rollouts(dict(zip(STIFF, [0, 1, 0, 1], strict=True)) | soft),
        }
    )
    assert len(cells) == 10
    table = ablation_table(cells, INSIDE).set_index(["without", "region"])
    assert table.less[WHOLE, "G^SO"] == 0
    found = table.loc["latency", "G^SO"]
    # from 100 % and 50 % to 0 and 25 %
    assert found.less == pytest.approx((1.0 + 0.25) / 2)
    assert found.jitter_rate == pytest.approx(0.125)
    assert (found.lower, found.upper) == (0.25, 1.0)
    assert (found.cells, found.policies) == (4, 8)
    assert table.less["latency", "outside"] == 0
    printed = printable_ablation(table.reset_index())
    assert "+62 % (+25 to +100)" in printed.to_string()
    assert "+0 % (too few cells)" in printed.to_string()
