import os
import subprocess
import sys

import mujoco
import numpy as np
import pandas as pd
import pytest
from matplotlib.image import imread

from t2l.figures import frames
from t2l.figures.fidelity import fidelity
from t2l.figures.frames import filmstrips
from t2l.figures.heatmap import replay_success, success_and_loss
from t2l.figures.style import write
from t2l.figures.tracking import tracking
from t2l.gains import Cell, Grid

GRID = Grid(kp=(32, 128, 512), kd=(2, 32), compliant_up_to_kp=128, overdamped_from_kd=32)


@pytest.fixture(scope="module")
def cells():
    rows = [(c.kp, c.kd, 0.9, 10, 0.01 * (i + 1), i / 10, 10) for i, c in enumerate(GRID.cells)]
    columns = ["kp", "kd", "replay_success", "replays", "validation_loss", "success", "rollouts"]
    # a table's order must not matter
    return pd.DataFrame(rows, columns=columns).sample(frac=1, random_state=0)


def test_heatmaps_have_kd_upward_and_kp_to_the_right(cells):
    figure = success_and_loss(cells, GRID, "title")
    image = figure.axes[0].images[0]
    assert image.origin == "lower"
    np.testing.assert_allclose(image.get_array(), [[0, 0.1, 0.2], [0.3, 0.4, 0.5]])
    assert [t.get_text() for t in figure.axes[0].get_xticklabels()] == ["32", "128", "512"]
    assert [t.get_text() for t in figure.axes[0].get_yticklabels()] == ["2", "32"]


def test_a_missing_cell_stays_blank(cells):
    figure = success_and_loss(cells[cells.kp != 512], GRID, "title")
    assert figure.axes[0].images[0].get_array().mask[:, 2].all()


def _fidelity_table():
    rows = [
        (kp, 2.0, hold, decimation, True, 10.0 ** (-9 + decimation / 5))
        for kp in (16.0, 512.0)
        for hold in ("mean", "sample")
        for decimation in (1, 10, 25)
    ]
    columns = ["kp", "kd", "hold", "decimation", "success", "mse_q_rad2"]
    return pd.DataFrame(rows, columns=columns)


def _tracking():
    wave = np.sin(np.linspace(0, 6, 100))[:, None] * np.ones(3)
    return tracking({Cell(32, 2): (wave, 0.9 * wave)}, {"joint 1": 0, "joint 3": 2}, 50, "title")


@pytest.mark.parametrize(
    "draw",
    [
        lambda cells, task: success_and_loss(cells, GRID, "title"),
        lambda cells, task: replay_success(cells, GRID, "title"),
        lambda cells, task: fidelity(_fidelity_table(), 500, "title"),
        lambda cells, task: _tracking(),
        lambda cells, task: filmstrips(
            task,
            {"start": (np.arange(4), task.sample_starts(np.random.default_rng(0), 4))},
            3,
            "title",
        ),
    ],
    ids=["success", "replay", "fidelity", "tracking", "frames"],
)
def test_a_figure_is_written_as_pdf_and_png_with_something_in_it(cells, task, tmp_path, draw):
    write(draw(cells, task), [tmp_path / "figure.pdf", tmp_path / "figure.png"])
    assert (tmp_path / "figure.pdf").read_bytes().startswith(b"%PDF")
    assert imread(tmp_path / "figure.png")[..., :3].std() > 0.05
    assert len(list(tmp_path.iterdir())) == 2


BY_OPENGL = """
import sys, mujoco, numpy as np
model = mujoco.MjModel.from_binary_path(sys.argv[1])
data = mujoco.MjData(model)
data.qpos[:] = np.load(sys.argv[2])
mujoco.mj_forward(model, data)
with mujoco.Renderer(model, *map(int, sys.argv[5:])) as renderer:
    renderer.update_scene(data, sys.argv[4])
    np.save(sys.argv[3], renderer.render())
"""


def _no_opengl(*arguments):
    raise RuntimeError("no display")


def test_without_opengl_the_picture_is_much_the_same(task, monkeypatch, tmp_path):
    start = task.sample_starts(np.random.default_rng(0), 1)
    model, pose, image = (tmp_path / name for name in ("model.mjb", "pose.npy", "image.npy"))
    mujoco.mj_saveModel(task.spec(visual=True).compile(), str(model))
    np.save(pose, start[0])
    files = [str(path) for path in (model, pose, image)]
    view = [frames.CAMERA, str(frames.HEIGHT), str(frames.WIDTH)]
    # Mesa's EGL needs neither a display nor a GPU; MuJoCo reads the variable when it is imported
    done = subprocess.run(
        [sys.executable, "-c", BY_OPENGL, *files, *view],
        env=os.environ | {"MUJOCO_GL": "egl"}, capture_output=True, text=True,
    )  # fmt: skip
    if done.returncode:
        pytest.skip(f"needs EGL: {done.stderr.splitlines()[-1]}")
    reference = np.load(image)
    monkeypatch.setattr(mujoco, "Renderer", _no_opengl)
    (drawn,) = frames.render(task, start)
    assert drawn.shape == reference.shape
    assert drawn.dtype == np.uint8
    # red and blue blocks where they are, the arm in front of the table
    for channel, other in ((0, 2), (2, 0)):
        masks = [i[..., channel].astype(int) - i[..., other] > 60 for i in (reference, drawn)]
        assert masks[0].sum() > 50
        assert (masks[0] & masks[1]).sum() > 0.6 * (masks[0] | masks[1]).sum()
    assert np.corrcoef(reference.mean(axis=2).ravel(), drawn.mean(axis=2).ravel())[0, 1] > 0.5
