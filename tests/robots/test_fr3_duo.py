import mujoco
import numpy as np
import pytest

from t2l.robots import make_robot, plant

ARMS = ("left", "right")


@pytest.fixture(scope="module")
def robot():
    return make_robot("fr3_duo")


@pytest.fixture(scope="module")
def model(robot):
    return robot.spec().compile()


def at_home(robot, model):
    data = mujoco.MjData(model)
    for name, angle in zip(robot.joints, robot.home, strict=True):
        data.qpos[model.joint(name).qposadr[0]] = angle
    mujoco.mj_kinematics(model, data)
    return data


def test_each_arm_is_a_group_with_names_and_a_gripper_of_its_own(robot, model):
    assert [group.name for group in robot.groups] == list(ARMS)
    assert len(set(robot.joints)) == len(robot.joints) == robot.home.size == robot.proximal.size
    for group in robot.groups:
        names = *group.joints, *group.gripper.joints, *group.gripper.actuators, group.tool_site
        assert all(name.startswith(f"{group.name}/") for name in names)
        for joint in group.joints:
            actuator = model.actuator(joint)
            assert model.actuator_trnid[actuator.id, 0] == model.joint(joint).id


def test_each_arm_is_the_one_arm(robot, model):
    one = make_robot("fr3_hand")
    alone = one.spec().compile()
    np.testing.assert_array_equal(robot.position_limit, np.tile(one.position_limit, (2, 1)))
    np.testing.assert_array_equal(robot.torque_limit, np.tile(one.torque_limit, 2))
    for field in ("dof_armature", "dof_frictionloss", "dof_solimp", "actuator_forcerange"):
        value = getattr(alone, field)
        np.testing.assert_array_equal(getattr(model, field), np.concatenate([value, value]), field)
    mass = alone.body_mass[1:]
    np.testing.assert_array_equal(model.body_mass[1:], np.concatenate([mass, mass]))


def test_at_home_the_hands_point_down_and_face_each_other(robot, model):
    data = at_home(robot, model)
    left, right = (data.site(f"{arm}/grip") for arm in ARMS)
    np.testing.assert_allclose(left.xpos, [-0.2, 0, 0.4], atol=2e-3)
    np.testing.assert_allclose(right.xpos, [0.2, 0, 0.4], atol=2e-3)
    np.testing.assert_allclose(left.xmat.reshape(3, 3), np.diag([1, -1, -1]), atol=1e-3)
    np.testing.assert_allclose(right.xmat.reshape(3, 3), np.diag([-1, 1, -1]), atol=1e-3)
    low, high = robot.position_limit.T
    assert np.all((robot.home - low > 0.6) & (high - robot.home > 0.6))


def test_arms_touch_each_other_and_never_themselves(model):
    colliders = np.flatnonzero(model.geom_contype)
    arm = {g: model.geom(g).name.split("/")[0] for g in colliders}
    for a in colliders:
        # a table has contype 1 and conaffinity 2
        assert (model.geom_contype[a] & 2) or (1 & model.geom_conaffinity[a])
        for b in colliders:
            touch = (model.geom_contype[a] & model.geom_conaffinity[b]) or (
                model.geom_contype[b] & model.geom_conaffinity[a]
            )
            assert bool(touch) == (arm[a] != arm[b])


def test_its_bare_arms_are_a_robot_too(robot):
    bare = plant.load(robot.name, robot.joints).compile()
    assert [bare.joint(i).name for i in range(bare.njnt)] == list(robot.joints)
    assert plant.files(robot.name) == plant.files("fr3")
