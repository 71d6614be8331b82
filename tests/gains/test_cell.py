import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from t2l.gains import Cell, Grid
from t2l.gains.cell import NAME_PATTERN

gains = st.floats(min_value=1e-6, max_value=1e6)


@given(kp=gains, kd=gains)
def test_a_cell_is_recovered_from_its_name(kp, kd):
    name = Cell(kp, kd).name
    assert re.fullmatch(NAME_PATTERN, name)
    assert Cell.from_name(name) == Cell(kp, kd)


def test_names_are_those_of_the_study():
    assert Cell(kp=16, kd=24).name == "kp16_kd24"
    assert Cell(kp=0.5, kd=2.25).name == "kp0.5_kd2.25"
    assert Cell(kp=1e-5, kd=1e6).name == "kp0.00001_kd1000000"


@pytest.mark.parametrize(
    ("kp", "kd", "key"), [(0, 1, "kp"), (1, -2, "kd"), (float("nan"), 1, "kp")]
)
def test_impossible_gains_are_named(kp, kd, key):
    with pytest.raises(ValueError, match=key):
        Cell(kp, kd)


def test_a_foreign_name_is_refused():
    with pytest.raises(ValueError, match="kp16_kd24"):
        Cell.from_name("16-24")


def test_regions_follow_the_split():
    grid = Grid(kp=(32, 512), kd=(2, 32), compliant_up_to_kp=128, overdamped_from_kd=32)
    assert [grid.region(cell) for cell in grid.cells] == ["CU", "SU", "CO", "SO"]
    assert grid.corners == grid.cells
    assert [c for c in grid.cells if grid.in_compliant_overdamped(c)] == [Cell(32, 32)]


def test_a_subset_of_a_grid_is_its_corners_and_its_centre():
    grid = Grid((32, 128, 512, 2048), (2, 8, 32), 128, 32, "corners_and_centre")
    named = "kp32_kd2 kp2048_kd2 kp128_kd8 kp32_kd32 kp2048_kd32"
    assert [cell.name for cell in grid.cells] == named.split()
