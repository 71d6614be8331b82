import mujoco
import numpy as np
import pytest

from t2l.errors import ConfigurationError
from t2l.robots import make_robot, menagerie, plant
from t2l.sim.batch import apply_position_gains, make_batch

ROBOT = make_robot("unitree_g1")
MODEL = ROBOT.bare().compile()
BODIES = [MODEL.body(i).name for i in range(1, MODEL.nbody)]
# of Unitree's 37 joints, as Menagerie printed it first
MASS_KG = 32.24


def inertia(model, body):
    """(3, 3) about the centre of mass, in the body's frame."""
    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, model.body(body).iquat)
    axes = rotation.reshape(3, 3)
    return axes @ np.diag(model.body(body).inertia) @ axes.T


def test_it_has_the_studys_joints_in_the_studys_groups():
    assert len(ROBOT.joints) == 37
    assert ROBOT.scale_groups == ("lower", "upper")
    assert np.bincount(ROBOT.scale_group).tolist() == [13, 24]
    lower = np.array(ROBOT.joints)[ROBOT.scale_group == 0]
    assert all("hip" in j or "knee" in j or "ankle" in j or j == "torso_joint" for j in lower)
    assert MODEL.body_mass.sum() == pytest.approx(MASS_KG, abs=5e-3)


def test_its_figures_are_the_official_files_where_that_is_installed():
    try:
        path = menagerie.model("unitree_g1", "g1.xml")
    except ConfigurationError as missing:
        pytest.skip(str(missing))
    official = mujoco.MjModel.from_xml_path(str(path))
    if official.njnt != MODEL.njnt:
        pytest.skip("a later revision of the robot; wanted is the file of commit 0a809cf")
    for name in BODIES:
        own, other = MODEL.body(name), official.body(name)
        for key in ("pos", "quat", "ipos", "mass"):
            np.testing.assert_allclose(getattr(own, key), getattr(other, key), atol=2e-6)
        moments = inertia(official, name)
        np.testing.assert_allclose(inertia(MODEL, name), moments, atol=1e-5 * moments.max())
    for name in ROBOT.joints:
        own, other = MODEL.joint(name), official.joint(name)
        np.testing.assert_array_equal(own.axis, other.axis)
        np.testing.assert_array_equal(own.range, other.range)


def test_the_right_side_is_the_mirrored_left_side():
    data = mujoco.MjData(MODEL)
    data.qpos[:] = MODEL.qpos0
    mujoco.mj_forward(MODEL, data)
    mirror = np.diag([1.0, -1.0, 1.0])
    for left in (name for name in BODIES if name.startswith("left_")):
        here, there = MODEL.body(left).id, MODEL.body(left.replace("left", "right")).id
        assert MODEL.body_mass[here] == MODEL.body_mass[there]
        np.testing.assert_allclose(data.xipos[there], mirror @ data.xipos[here], atol=1e-9)
        axes = [data.xmat[i].reshape(3, 3) for i in (here, there)]
        names = [MODEL.body(i).name for i in (here, there)]
        moments = [a @ inertia(MODEL, n) @ a.T for a, n in zip(axes, names, strict=True)]
        np.testing.assert_allclose(moments[1], mirror @ moments[0] @ mirror, rtol=1e-4, atol=1e-10)


def test_gains_of_a_cell_are_factors_on_its_own():
    stiffness, damping = ROBOT.gains(0.25, 4.0)
    knee, ankle = (ROBOT.joints.index(f"left_{name}_joint") for name in ("knee", "ankle_roll"))
    assert (stiffness[knee], damping[knee]) == (50.0, 20.0)
    assert (stiffness[ankle], damping[ankle]) == (5.0, 8.0)
    # rows of cells give rows of joints
    assert ROBOT.gains(np.ones((3, 1)), np.ones((3, 1)))[0].shape == (3, 37)
    # of other robots they are the gains themselves
    arm = make_robot("fr3").gains(16, 24)
    assert [set(gain) for gain in arm] == [{16.0}, {24.0}]


def test_home_is_within_its_ranges_and_its_feet_are_just_above_the_ground():
    low, high = ROBOT.position_limit.T
    assert np.all((ROBOT.home >= low) & (ROBOT.home <= high))
    data = mujoco.MjData(MODEL)
    data.qpos[2], data.qpos[7:] = ROBOT.walker.height_m, ROBOT.home
    mujoco.mj_kinematics(MODEL, data)
    touching = MODEL.geom_contype > 0
    assert 0.0 < data.geom_xpos[touching, 2].min() < 0.03


def test_its_feet_carry_its_weight():
    spec = ROBOT.spec()
    spec.option.timestep = 0.005
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_DISCRETE
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=(0, 0, 1), conaffinity=2)
    model = spec.compile()
    batch = make_batch(model, 1)
    apply_position_gains(batch, ROBOT.joints, *ROBOT.gains(4.0, 4.0))
    # held upright by its base alone, which may go up and down
    batch.qpos[:, 2], batch.qpos[:, 7:] = ROBOT.walker.height_m, ROBOT.home
    batch.ctrl[:] = ROBOT.home
    carried = batch.bind("qfrc_constraint")
    for _ in range(300):
        batch.step()
        batch.qpos[:, 3:7], batch.qvel[:, 3:6] = (1, 0, 0, 0), 0.0
    np.testing.assert_allclose(carried[0, 2], MASS_KG * 9.81, rtol=0.02)


def test_without_visuals_it_has_only_what_touches():
    plain, seen = (ROBOT.spec(visual=visual).compile() for visual in (False, True))
    assert plain.ngeom < seen.ngeom
    assert np.all(plain.geom_contype == 2)
    np.testing.assert_array_equal(plain.body_mass, seen.body_mass)


def test_its_base_floats():
    assert plant.free_joints("unitree_g1") == [ROBOT.walker.base]
