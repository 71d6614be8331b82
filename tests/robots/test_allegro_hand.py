import mujoco
import numpy as np
import pytest

from t2l.errors import ConfigurationError
from t2l.robots import make_robot, menagerie
from t2l.sim.batch import apply_position_gains, make_batch

ROBOT = make_robot("allegro_hand")
MODEL = ROBOT.bare().compile()
BODIES = [MODEL.body(i).name for i in range(1, MODEL.nbody)]
# of palm and links together, as descriptions of the hand state them
MASS_KG = 0.9549


def test_three_fingers_share_an_action_scale_and_the_thumb_has_another():
    assert len(ROBOT.joints) == 16
    assert ROBOT.scale_groups == ("fingers", "thumb")
    assert np.bincount(ROBOT.scale_group).tolist() == [12, 4]
    thumb = np.array(ROBOT.joints)[ROBOT.scale_group == 1]
    assert all(name.startswith("th") for name in thumb)
    assert MODEL.body_mass.sum() == pytest.approx(MASS_KG, abs=5e-5)


def test_its_frames_are_the_official_files_where_that_is_installed():
    try:
        path = menagerie.model("wonik_allegro", "right_hand.xml")
    except ConfigurationError as missing:
        pytest.skip(str(missing))
    official = mujoco.MjModel.from_xml_path(str(path))
    # it is mounted in another way
    for name in BODIES[1:]:
        own, other = MODEL.body(name), official.body(name)
        for key in ("pos", "quat"):
            np.testing.assert_allclose(getattr(own, key), getattr(other, key), atol=2e-6)
    for name in ROBOT.joints:
        own, other = MODEL.joint(name), official.joint(name)
        np.testing.assert_array_equal(own.axis, other.axis)
        np.testing.assert_array_equal(own.range, other.range)


def test_gains_of_a_cell_are_factors_on_its_own():
    stiffness, damping = ROBOT.gains(0.25, 4.0)
    assert (set(stiffness), set(damping)) == ({0.75}, {0.4})


def test_its_palm_looks_up_and_its_fingers_bend_over_it():
    data = mujoco.MjData(MODEL)
    mujoco.mj_kinematics(MODEL, data)
    palm = data.site(ROBOT.palm)
    normal, place = palm.xmat.reshape(3, 3)[:, 2], palm.xpos.copy()
    # its tilt is IsaacLab's, 10 degrees
    assert normal[2] == pytest.approx(np.cos(np.radians(9.9)), abs=1e-3)
    flat = (data.body("mf_distal").xpos - place) @ normal
    data.qpos[:] = ROBOT.position_limit[:, 1] / 2
    mujoco.mj_kinematics(MODEL, data)
    for finger in ("ff", "mf", "rf"):
        assert (data.body(f"{finger}_distal").xpos - place) @ normal > flat + 0.04


def test_home_is_within_its_ranges_and_nothing_of_the_hand_touches_there():
    low, high = ROBOT.position_limit.T
    assert np.all((ROBOT.home >= low) & (ROBOT.home <= high))
    data = mujoco.MjData(MODEL)
    data.qpos[:] = ROBOT.home
    mujoco.mj_fwdPosition(MODEL, data)
    assert data.ncon == 0


def test_two_fingers_stop_each_other():
    spec = ROBOT.spec()
    spec.option.timestep = 0.005
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_DISCRETE
    model = spec.compile()
    batch = make_batch(model, 1)
    apply_position_gains(batch, ROBOT.joints, *ROBOT.gains(1.0, 1.0))
    # bent, and led across one another
    bent = np.tile([0.0, 1.2, 0.2, 0.2], 4)
    bent[12:] = ROBOT.home[12:]
    batch.qpos[:] = bent
    bent[[0, 4]] = 0.47, -0.47
    batch.ctrl[:] = bent
    for _ in range(200):
        batch.step()
    assert np.isfinite(batch.qpos).all()
    assert np.abs(batch.qpos[0] - bent)[[0, 4]].max() > 0.05
