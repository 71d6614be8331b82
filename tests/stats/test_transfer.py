import numpy as np
import pandas as pd
import pytest
from scipy.stats import mannwhitneyu

from t2l.gains import Grid
from t2l.stats.text import latex
from t2l.stats.transfer import (
    HEADERS,
    existence_table,
    jitter_table,
    log_error_regression,
    of_policies,
    printable_existence,
    printable_jitter,
    printable_transfer,
    transfer_table,
)

GRID = Grid(kp=(16, 128, 512), kd=(1, 8, 24), compliant_up_to_kp=128, overdamped_from_kd=8)


def rollouts(slope_kp=0.5, slope_kd=-0.3, spread=0.1, n=10, jitters=0, seeds=1):
    """Errors that follow the gains exactly, but for a deviation a cell and one a rollout."""
    draw, rows = np.random.default_rng(0), []
    deviations = draw.normal(0, spread, len(GRID.cells))
    for cell, own in zip(GRID.cells, deviations, strict=True):
        for i in range(n):
            log = slope_kp * np.log2(cell.kp) + slope_kd * np.log2(cell.kd) + own
            error = np.exp(log + draw.normal(0, spread / 5))
            rows.append((cell.kp, cell.kd, i % seeds, error, i < jitters))
    table = pd.DataFrame(rows, columns=["kp", "kd", "seed", "trajectory_error", "jitter_failure"])
    return table.assign(jitter_failure_sim=False, stopped="")


def test_the_slopes_of_log_error_are_recovered_within_their_errors():
    fit = log_error_regression(of_policies(rollouts(seeds=2)))
    assert abs(fit.kp - 0.5) < 3 * fit.kp_error
    assert abs(fit.kd + 0.3) < 3 * fit.kd_error
    assert max(fit.kp_p, fit.kd_p) < 0.01


def test_a_policy_counts_by_the_mean_of_its_rollouts():
    table = rollouts(n=4, seeds=2)
    first = of_policies(table).iloc[0]
    own = table[(table.kp == 16) & (table.kd == 1) & (table.seed == 0)].trajectory_error
    assert len(own) == 2
    assert first["log"] == pytest.approx(np.log(own.mean()))


def test_policies_of_a_cell_do_not_count_as_so_many_experiments():
    def error(seeds):
        return log_error_regression(of_policies(rollouts(n=20, seeds=seeds))).kp_error

    # ten times the policies in the same cells tell hardly more about the gains
    assert error(20) == pytest.approx(error(2), rel=0.2)


def test_what_two_cells_cannot_tell_is_not_told():
    table = rollouts()
    table = table[table.kd == 1]
    assert np.isnan(log_error_regression(of_policies(table)).kp)
    printed = printable_transfer(transfer_table({"joint_reach": table}, GRID))
    assert printed["β log2 Kp"][0] == "undetermined"
    assert printed["p (cells)"][0] == "cannot be told"
    assert printed["Error in G^SO"][0] == "no cells"


def test_the_table_compares_the_stiff_overdamped_cells_with_the_rest():
    tables = {"one": rollouts(slope_kd=0.4), "other": rollouts(slope_kp=-0.5, slope_kd=-0.5)}
    table = transfer_table(tables, GRID)
    inside = (tables["one"].kp == 512) & (tables["one"].kd >= 8)
    error = tables["one"].trajectory_error
    assert (table.rollouts_so[0], table.rollouts_rest[0]) == (20, 70)
    assert table.error_so[0] == pytest.approx(error[inside].mean())
    single = mannwhitneyu(error[inside], error[~inside], alternative="greater").pvalue
    assert table.p_rollouts[0] == pytest.approx(2 * single)
    assert table.p_rollouts[0] < 0.001
    assert table.p_rollouts[1] == 1.0


def test_cells_are_judged_only_where_they_could_decide():
    """Two of nine cells attain 1/36, and twice that where two conditions are compared."""
    rising, falling = rollouts(slope_kd=0.4), rollouts(slope_kp=-0.5, slope_kd=-0.5)
    alone = transfer_table({"one": rising}, GRID)
    assert (alone.cells_so[0], alone.cells_rest[0]) == (2, 7)
    assert alone.p_cells[0] == pytest.approx(1 / 36)
    both = transfer_table({"one": rising, "other": falling}, GRID)
    assert both.least_p_cells.tolist() == pytest.approx([2 / 36, 2 / 36])
    assert both.p_cells.isna().all()


@pytest.mark.parametrize("slope", [-1.0, 0.0, 1.0])
def test_corners_and_centre_cannot_tell_whatever_the_data(slope):
    """One cell in G^SO against four: the least p is 0.2, and 1.000 for six conditions."""
    table = rollouts(slope_kp=slope, slope_kd=slope)
    corner = table.kp.isin([16, 512]) & table.kd.isin([1, 24])
    five = table[corner | ((table.kp == 128) & (table.kd == 8))]
    found = transfer_table({f"condition_{i}": five for i in range(6)}, GRID)
    assert found.p_cells.isna().all()
    assert set(printable_transfer(found)["p (cells)"]) == {"cannot be told"}
    assert set(printable_transfer(found)["Cells"]) == {"1 + 4"}


def test_rollouts_without_an_error_are_not_left_out_unseen():
    table = rollouts()
    table.loc[:4, "trajectory_error"] = np.nan
    made = transfer_table({"a": table}, GRID)
    assert made.rollouts_rest[0] == 70
    assert np.isnan(made.error_rest[0])
    assert np.isnan(made.beta_kp[0])


def test_an_error_of_zero_has_a_logarithm():
    table = rollouts().assign(trajectory_error=0.0)
    assert np.isfinite(of_policies(table)["log"]).all()


def test_jitter_by_period_is_ordered_and_its_intervals_are_over_cells():
    tables = {"fast": rollouts(jitters=5), "slow": rollouts(jitters=0)}
    table = jitter_table(tables, {"slow": 10.0, "fast": 100.0})
    assert table.condition.tolist() == ["fast", "slow"]
    assert table.period_s.tolist() == [0.01, 0.1]
    assert table.jitter_rate.tolist() == [0.5, 0.0]
    # every cell jitters alike, however many rollouts it has
    assert table.lower.tolist() == table.upper.tolist() == [0.5, 0.0]
    assert printable_jitter(table)["Policy period"].tolist() == ["10 ms", "100 ms"]
    one_cell = rollouts(n=10)
    one_cell.loc[one_cell.kp == 512, "jitter_failure"] = True
    table = jitter_table({"a": one_cell}, {"a": 50.0})
    assert table.jitter_rate[0] == pytest.approx(1 / 3)
    # of 9 cells: the binomial's 2.5 and 97.5 %
    assert 0 <= table.lower[0] < 0.12
    assert 0.6 < table.upper[0] < 0.7


def test_rollouts_that_were_stopped_are_told_apart():
    table = rollouts(jitters=5)
    table["stopped"] = np.where(table.jitter_failure & (table.kp == 16), "too fast", "")
    made = jitter_table({"a": table}, {"a": 50.0})
    assert made.jitter_rate[0] == 0.5
    assert made.stopped_rate[0] == pytest.approx(0.5 / 3)


def test_solutions_exist_by_corner():
    cells = pd.DataFrame({"kp": [16.0, 512.0], "kd": [1.0, 24.0], "success_sim_100": [0.99, 0.5]})
    printed = printable_existence(existence_table({"joint_reach": cells}, GRID))
    assert printed.iloc[0].tolist() == ["Joint Reach", "99.0 %", "not run", "not run", "50.0 %"]


def test_tables_are_latex_too():
    text = latex(printable_transfer(transfer_table({"a_b": rollouts()}, GRID)), HEADERS)
    assert r"\mathcal{G}^{\mathrm{SO}}" in text
    assert "±" not in text
    assert text.count("\\\\") >= 2
    assert r"95 \% interval" in latex(
        printable_jitter(jitter_table({"a": rollouts()}, {"a": 50.0})), HEADERS
    )
