import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from t2l.demos.episodes import read_episodes, write_episodes
from t2l.errors import ArtefactError


@pytest.fixture
def episodes(task):
    rng = np.random.default_rng(0)
    return [
        (
            rng.normal(size=(n, len(task.observation_names))).astype(np.float32),
            rng.normal(size=(n, 8)).astype(np.float32),
        )
        for n in (3, 1, 5)
    ]


@pytest.fixture
def path(episodes, tmp_path):
    write_episodes(episodes, tmp_path / "episodes.parquet")
    return tmp_path / "episodes.parquet"


def test_episodes_survive_the_disk_to_the_last_bit(task, episodes, path):
    for written, read in zip(episodes, read_episodes(path, task), strict=True):
        for a, b in zip(written, read, strict=True):
            assert a.dtype == b.dtype
            np.testing.assert_array_equal(a, b)


def _changed(key, values):
    def change(table):
        at = table.column_names.index(key)
        return table.set_column(at, key, values(table[key].to_pylist()))

    return change


def _shorter(lists):
    return pa.array([lists[0][:-1], *lists[1:]], pa.list_(pa.float32()))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda table: table.drop_columns("action"), "lacks column action"),
        (lambda table: table.slice(0, 0), "no rows"),
        (_changed("action", _shorter), "action has lists of other lengths"),
        (
            _changed("observation", lambda lists: pa.array([row[:4] for row in lists])),
            "observation has lists of 4.* lists of [0-9]+ numbers",
        ),
        (_changed("observation", lambda lists: pa.array([1.0] * 9)), "observation is double"),
        (_changed("episode_index", lambda rows: pa.array([0.5] * 9)), "episode_index is double"),
    ],
    ids=["column", "empty", "lengths", "another task", "numbers", "index"],
)
def test_a_foreign_table_is_named(task, path, change, message):
    pq.write_table(change(pq.read_table(path)), path)
    with pytest.raises(ArtefactError, match=message) as error:
        read_episodes(path, task)
    assert error.value.path == path
