import os
import subprocess
import sys

import matplotlib.pyplot as plt
import mujoco
import numpy as np
import pandas as pd
import pytest
from matplotlib.image import imread

from t2l.figures import frames
from t2l.figures.fidelity import fidelity
from t2l.figures.frames import filmstrips
from t2l.figures.identification import over_true
from t2l.figures.success import replay_success, success_and_loss
from t2l.figures.tracking import tracking
from t2l.gains import Cell, Grid
from t2l.plotting.style import DPI, write

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


def test_losses_that_are_alike_look_alike(cells):
    alike = cells.assign(validation_loss=0.01 + 1e-4 * np.arange(len(cells)))
    image = success_and_loss(alike, GRID, "title").axes[1].images[0]
    shade = image.norm(np.asarray(image.get_array()))
    assert shade.max() - shade.min() < 0.05


def _over_true(kp, kd):
    rows = [
        (p, d, f"arm_joint{j}", name, 1.0, 1.0, j * p / d)
        for p in kp for d in kd for j in (1, 2) for name in ("Kp", "armature", "breakaway")
    ]  # fmt: skip
    columns = ["kp", "kd", "joint", "parameter", "identified", "true", "ratio"]
    return pd.DataFrame(rows, columns=columns).sample(frac=1, random_state=0)


def test_identified_over_true_is_a_map_for_each_parameter_and_joint(tmp_path):
    table = _over_true((16, 64, 512), (2, 8)).iloc[:-1]
    figure = over_true(table)
    maps = [panel for panel in figure.axes if panel.images]
    assert len(maps) == 6
    assert {panel.get_title() for panel in maps[:2]} == {"joint1", "joint2"}
    for panel in maps:
        assert panel.images[0].get_array().shape == (2, 3)
        assert panel.images[0].origin == "lower"
    # letters as large as the page's own where it is 8.6 inches wide
    sizes = [t.get_fontsize() for p in maps for t in (*p.get_xticklabels(), p.title, p.yaxis.label)]
    assert min(sizes) >= 8
    wide = over_true(_over_true(tuple(range(1, 8)), tuple(range(1, 8))))
    assert wide.get_size_inches()[0] < 10
    write(figure, [tmp_path / "figure.png"])
    assert imread(tmp_path / "figure.png").shape[1] == round(DPI * figure.get_size_inches()[0])
    plt.close(wide)


def test_identified_over_true_of_one_cell_has_its_numbers():
    figure = over_true(_over_true((16,), (8,)))
    (panel,) = [panel for panel in figure.axes if panel.images]
    assert panel.images[0].get_array().shape == (3, 2)
    assert {text.get_text() for text in panel.texts} == {"2", "4"}
    plt.close(figure)


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
