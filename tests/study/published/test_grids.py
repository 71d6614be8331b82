import json
from pathlib import Path

import pytest

from t2l.errors import InputError
from t2l.study.published.grids import COLUMNS, read_grids

TASK = {
    "kps": [32, 64], "kds": [1, 2, 4],
    "validation": [[0.1, 0.2], [0.3, 0.4], [0.5, 0.6]],
    "replay": [[1, 1], [1, 1], [1, 0.5]],
    "loss": [[0.01, 0.02], [0.03, 0.04], [0.05, 0.06]],
}  # fmt: skip


def _file(folder: Path, **changes) -> Path:
    path = folder / "page.json"
    path.write_text(json.dumps({"taskData": {"Mug Hanging": {**TASK, **changes}}}))
    return path


def test_rows_are_by_damping_and_columns_by_stiffness(tmp_path):
    table = read_grids(_file(tmp_path))["Mug Hanging"]
    assert tuple(table.columns) == COLUMNS
    by_cell = table.set_index(["kp", "kd"])
    assert by_cell.success[(64, 1)] == 0.2
    assert by_cell.loss[(32, 4)] == 0.05
    assert by_cell.replay_success[(64, 4)] == 0.5


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"loss": [[0.01, 0.02]]}, r"Mug Hanging.loss: found 1 by 2 numbers; allowed: 3 by 2"),
        ({"validation": None}, r"Mug Hanging.validation: found something else"),
        ({"kps": ["soft", "stiff"]}, r"Mug Hanging.kps: found something else; allowed: a list"),
    ],
)
def test_what_is_not_the_pages_file_is_refused(tmp_path, changes, said):
    with pytest.raises(InputError, match=said):
        read_grids(_file(tmp_path, **changes))


@pytest.mark.parametrize("text", ["[]", "{}", '{"taskData": []}'])
def test_a_file_without_tasks_is_refused(tmp_path, text):
    path = tmp_path / "page.json"
    path.write_text(text)
    with pytest.raises(InputError, match="taskData: found no tasks"):
        read_grids(path)
