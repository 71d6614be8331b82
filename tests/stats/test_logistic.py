import numpy as np
import pytest

from t2l.stats.logistic import logistic_regression

# (kp, kd, successes, failures): odds 1, 2, 1/3, 2/3, so a doubling of Kp doubles the odds
# and a doubling of Kd divides them by three
COUNTS = [(32, 2, 60, 60), (64, 2, 80, 40), (32, 4, 30, 90), (64, 4, 48, 72)]


def _expand(counts):
    rows = [(kp, kd, y) for kp, kd, s, f in counts for y in [True] * s + [False] * f]
    return (np.array(column) for column in zip(*rows, strict=True))


def test_coefficients_and_errors_by_hand():
    fit = logistic_regression(*_expand(COUNTS))
    assert fit.kp == pytest.approx(np.log(2), abs=1e-8)
    assert fit.kd == pytest.approx(-np.log(3), abs=1e-8)
    design = np.array([[1, np.log2(kp), np.log2(kd)] for kp, kd, *_ in COUNTS])
    weights = [(s + f) * s / (s + f) * f / (s + f) for *_, s, f in COUNTS]
    information = design.T @ np.diag(weights) @ design
    errors = np.sqrt(np.diag(np.linalg.inv(information)))
    assert (fit.kp_error, fit.kd_error) == pytest.approx(tuple(errors[1:]), rel=1e-6)


@pytest.mark.parametrize(
    "counts",
    [
        [(32, 2, 0, 9), (64, 4, 0, 9), (32, 4, 0, 9)],
        [(32, 2, 9, 0), (64, 4, 9, 0), (32, 4, 9, 0)],
        [(32, 2, 0, 9), (64, 2, 9, 0), (32, 4, 0, 9), (64, 4, 9, 0)],
        [(32, 2, 4, 5), (64, 2, 5, 4)],
    ],
    ids=["all failures", "all successes", "separated", "one damping"],
)
def test_what_data_do_not_determine_is_not_a_number(counts):
    fit = logistic_regression(*_expand(counts))
    assert np.isnan([fit.kp, fit.kd, fit.kp_error, fit.kd_error]).all()
