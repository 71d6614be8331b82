import numpy as np
import pytest
import yaml
from mujoco import mjtGeom

from t2l.demos import rehearsal
from t2l.demos.rehearsal import rehearse
from t2l.errors import CameraError, ConfigurationError, ExpertError, RendererError
from t2l.tasks.block_stack import BlockStack
from tests.conftest import ROOT

SKY = [{"cameras": ["sky"], "size_px": 32}]
GLOBAL = [{"cameras": ["global"], "size_px": 32}]


def _try(parameters, observations=(), count=50, max_attempts=100):
    rng = np.random.default_rng(0)
    rehearse("mine", parameters, count, max_attempts, rng, observations, threads=2)


@pytest.fixture
def with_scene(monkeypatch, block_stack):
    """Parameters of Block Stack, whose scene has from then on what a function adds to it."""
    before = BlockStack.spec

    def made(add):
        def spec(self, visual):
            scene = before(self, visual)
            add(scene, visual)
            return scene

        monkeypatch.setattr(BlockStack, "spec", spec)
        return block_stack

    return made


def test_a_task_that_works_is_tried_with_one_attempt(block_stack, monkeypatch):
    tried = []
    attempt = rehearsal.attempt
    monkeypatch.setattr(
        rehearsal,
        "attempt",
        lambda task, starts, *rest: tried.append(len(starts)) or attempt(task, starts, *rest),
    )
    _try(block_stack, GLOBAL)
    assert tried == [1]


def test_an_expert_that_cannot_is_named_after_as_many_attempts_as_it_takes(block_stack):
    # too heavy for the friction of the fingertips
    with pytest.raises(ExpertError, match=r"config/tasks/mine.yaml: .* in 10 of 10 attempts"):
        _try({**block_stack, "block_mass_kg": 60.0})


@pytest.mark.parametrize(
    ("count", "most", "attempts"), [(10, 10, 8), (50, 100, 10), (10, 100, 66), (1, 10_000, 128)]
)
def test_an_expert_that_would_do_seldom_fails_in_all_of_them(count, most, attempts):
    assert rehearsal._attempts(count, most) == attempts
    if 8 < attempts < 128:
        assert (1 - count / most) ** attempts <= 1e-3 < (1 - count / most) ** (attempts - 1)


def test_a_horizon_shorter_than_the_expert_takes_is_named(block_stack):
    with pytest.raises(
        ConfigurationError, match=r"horizon_s: found 2; allowed: no less than the \d"
    ):
        _try(block_stack | {"horizon_s": 2.0})


def test_a_scene_of_bodies_inside_each_other_is_named():
    dishwasher = yaml.safe_load((ROOT / "config/tasks/dishwasher.yaml").read_text())
    with pytest.raises(ConfigurationError, match=r"found \w+ and dishwasher \d+ mm inside each"):
        # where the arm is
        _try({**dishwasher, "front_x_m": [0.0, 0.1]})


def test_a_scene_that_does_not_compile_is_named(with_scene):
    def add(spec, visual):
        spec.worldbody.add_body(name="ghost").add_freejoint()

    with pytest.raises(ConfigurationError, match=r"mine.yaml: the scene: .*mass and inertia"):
        _try(with_scene(add))


def test_a_scene_whose_visuals_do_not_compile_is_named(with_scene):
    def add(spec, visual):
        if visual:
            spec.worldbody.add_geom(name="x", type=mjtGeom.mjGEOM_MESH, meshname="nowhere")

    with pytest.raises(ConfigurationError, match="mesh 'nowhere' not found"):
        _try(with_scene(add), GLOBAL)


def test_a_camera_that_sees_nothing_is_named(with_scene):
    def add(spec, visual):
        if visual:
            spec.worldbody.add_camera(name="sky", pos=(0, 0, 50), xyaxes=(1, 0, 0, 0, -1, 0))

    parameters = with_scene(add)
    with pytest.raises(CameraError, match=r"mine.yaml: camera sky: found pictures of one colour"):
        _try(parameters, SKY)
    _try(parameters, GLOBAL)


def test_where_nothing_can_render_cameras_are_left_to_the_jobs(block_stack, monkeypatch):
    """The machine that starts jobs of a cluster may be poorer than theirs."""

    def none(*arguments, **more):
        raise RendererError("no OpenGL")

    monkeypatch.setattr(rehearsal, "Cameras", none)
    _try(block_stack, SKY)
