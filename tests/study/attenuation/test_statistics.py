import numpy as np
import pandas as pd
import pytest

from t2l.gains import Grid
from t2l.stats.text import write_printed
from t2l.study.attenuation.rack import COLUMNS
from t2l.study.attenuation.statistics import (
    effective_error_table,
    noise_table,
    printable_effective_error,
    printable_noise,
    printable_variance,
    variance_table,
)
from tests.study.published.downloaded import STUDY, published_grids

GRID = Grid(kp=(32, 512), kd=(2, 32), compliant_up_to_kp=128, overdamped_from_kd=32)


def _held(variance):
    """Two plants in two cells, of which (32, 32) has h Kp / (2 Kd) = 0.01 and (512, 2) 2.56."""
    rows = [
        (
            plant,
            inertia,
            kp,
            kd,
            0.02,
            0.1,
            8,
            variance(inertia, small),
            0.0,
            small / 100,
            small,
            small,
        )
        for plant, inertia in (("light", 0.1), ("heavy", 1.0))
        for kp, kd, small in ((32, 32, 0.01), (64, 64, 0.01), (512, 2, 2.56))
    ]
    return pd.DataFrame(rows, columns=list(COLUMNS))


def test_means_are_over_cells_and_the_theorem_is_judged_where_it_is_small():
    table = variance_table(_held(lambda m, small: 0.01 * small * (1.1 if small < 1 else 0.3)))
    rows = table.set_index(["quantity", "plant"])
    theorem = rows.loc[("simulated / theorem, small h Kp/(2 Kd)", "light")]
    assert (theorem.value, theorem.cells) == (pytest.approx(1.1), 2)
    exact = rows.loc[("simulated / exact", "light")]
    assert (exact.value, exact.cells) == (pytest.approx((0.011 + 0.011 + 0.003) / 3), 3)


@pytest.mark.parametrize("power", [0.0, 1.0])
def test_a_planted_dependence_on_inertia_is_found(power):
    table = variance_table(_held(lambda m, small: 0.01 * small * m**power))
    slope = table.iloc[-1]
    assert slope.value == pytest.approx(power)
    assert slope.cells == 2
    assert len(printable_variance(table)) == len(table)


def test_success_that_follows_the_effective_error_is_found():
    rng = np.random.default_rng(0)
    kp, kd = np.meshgrid([32.0, 64, 128, 256, 512], [2.0, 8, 32, 128])
    loss = rng.lognormal(0, 2, kp.size)
    # attenuation times loss, in rank order
    order = np.argsort(np.argsort(kp.ravel() / kd.ravel() * loss))
    cells = pd.DataFrame(
        {"kp": kp.ravel(), "kd": kd.ravel(), "loss": loss, "success": 1 - order / 20, "seeds": 3}
    )
    table = effective_error_table({"block_stack": cells}, 0.02).set_index("predictor")
    assert table.rho["effective_error"] == pytest.approx(-1)
    assert table.stronger_low["damping_over_stiffness"] > 0
    assert set(table.cells) == {20}
    printed = printable_effective_error(table.reset_index())
    assert printed["Grid"][0] == "Block Stack"
    assert printed["ρ with success (95 %)"][0].startswith("-1.00 (-1.00 to -1.00")


def test_success_under_noise_by_region(tmp_path):
    rows = [
        (cell.kp, cell.kd, condition, 0.03, i < count)
        for condition in ("same", "own")
        for cell, count in zip(GRID.cells, (2, 0, 4, 1), strict=True)
        for i in range(4)
    ]
    columns = ["kp", "kd", "condition", "magnitude_rad", "success"]
    replays = {"block_stack": pd.DataFrame(rows, columns=columns)}
    undisturbed = {"block_stack": pd.DataFrame({"kp": 32, "kd": [2, 32], "replay_success": 1.0})}
    table = noise_table(replays, undisturbed, GRID)
    same = table.set_index("condition").loc["same"]
    assert (same.success_co, same.success_cu) == (1.0, 0.5)
    assert (same.success_so, same.success_su) == (0.25, 0.0)
    # Kp / Kd of CU and SO are equal: ranks 1, 2.5, 2.5, 4 against 4, 3, 2, 1
    assert same.rho == pytest.approx(-0.9486833)
    printed = printable_noise(table)
    assert printed["CO"].tolist() == ["100.0 %"] * 3
    assert printed["SU"].tolist() == ["no cells", "0.0 %", "0.0 %"]
    paths = [tmp_path / f"noise.{suffix}" for suffix in ("csv", "md", "tex")]
    write_printed(table, printed, paths)
    assert all(path.stat().st_size > 100 for path in paths)


@pytest.mark.skipif(not STUDY.is_file(), reason=f"the study's published grids are not at {STUDY}")
def test_the_studys_own_grids_give_the_published_ranks(tmp_path):
    grids = {name: cells.assign(seeds=1) for name, cells in published_grids(tmp_path).items()}
    table = effective_error_table(grids, 0.02)
    rho = table[table.predictor == "effective_error"].rho
    assert len(rho) == 5
    assert (rho.min(), rho.max()) == (
        pytest.approx(-0.88, abs=0.01),
        pytest.approx(-0.67, abs=0.01),
    )
    # beside Kd / Kp alone, the loss adds nothing
    ratio = table[table.predictor == "damping_over_stiffness"]
    assert ((ratio.stronger_low < 0) & (ratio.stronger_high > 0)).all()
