import numpy as np
from scipy.spatial.transform import Rotation

from t2l.tasks.waypoints import POINTING_DOWN, Arc, Waypoint, in_step, motion_through, padded


def test_a_motion_meets_its_waypoints_and_its_rates_are_its_derivatives():
    timestep = 0.002
    start = Waypoint(np.array([0.5, 0, 0.3]), POINTING_DOWN, 0, 0.04)
    end = Waypoint(
        np.array([0.4, 0.1, 0.1]), Rotation.from_rotvec([0, 0, 0.6]) * POINTING_DOWN, 1.0, 0.0
    )
    motion = motion_through(start, [end], timestep)
    assert len(motion.gripper) == 500
    np.testing.assert_allclose(motion.position[-1], end.position)
    np.testing.assert_allclose(motion.rotation[-1], end.rotation.as_matrix(), atol=1e-12)
    np.testing.assert_allclose(motion.twist[-1], 0, atol=1e-12)
    velocity = np.gradient(motion.position, timestep, axis=0)
    np.testing.assert_allclose(motion.twist[5:-5, :3], velocity[5:-5], atol=1e-4)
    acceleration = np.gradient(motion.twist, timestep, axis=0)
    np.testing.assert_allclose(motion.acceleration[5:-5], acceleration[5:-5], atol=1e-3)
    turn = (
        Rotation.from_matrix(motion.rotation[101]) * Rotation.from_matrix(motion.rotation[99]).inv()
    )
    np.testing.assert_allclose(motion.twist[100, 3:], turn.as_rotvec() / 0.004, atol=1e-4)


def test_an_arc_keeps_its_distance_and_its_rates_are_its_derivatives():
    timestep, pivot = 0.002, np.array([0.6, 0.1, 0.1])
    start = Waypoint(np.array([0.55, 0.0, 0.4]), POINTING_DOWN, 0, 0.04)
    axis = np.array([0.2, -0.97, 0.1]) / np.linalg.norm([0.2, -0.97, 0.1])
    end = Arc.after(start, POINTING_DOWN, 1.0, pivot, 1.1 * axis)
    assert end.gripper == start.gripper
    motion = motion_through(start, [end], timestep)
    arm = motion.position - pivot
    np.testing.assert_allclose(np.linalg.norm(arm, axis=1), np.linalg.norm(start.position - pivot))
    np.testing.assert_allclose(arm @ axis, (start.position - pivot) @ axis)
    np.testing.assert_allclose(motion.position[-1], end.position)
    velocity = np.gradient(motion.position, timestep, axis=0)
    np.testing.assert_allclose(motion.twist[5:-5, :3], velocity[5:-5], atol=1e-4)
    np.testing.assert_allclose(motion.twist[:, 3:], 0, atol=1e-12)
    acceleration = np.gradient(motion.twist, timestep, axis=0)
    np.testing.assert_allclose(motion.acceleration[5:-5], acceleration[5:-5], atol=1e-3)


def test_tools_in_step_wait_for_each_other():
    near, far = ((np.full(3, x), POINTING_DOWN, 0.04) for x in (0.1, 0.5))
    one, other = in_step([(0.4, (near, near)), (0.2, (far, None)), (0.6, (None, far))])
    assert [w.duration_s for w in one] == [w.duration_s for w in other] == [0.4, 0.2, 0.6]
    start = Waypoint(np.zeros(3), POINTING_DOWN, 0, 0.04)
    first, second = (motion_through(start, tool, 0.002).position[:, 0] for tool in (one, other))
    np.testing.assert_allclose(second[200:300], 0.1)
    np.testing.assert_allclose(first[300:], 0.5)
    assert first[250] > 0.1
    assert second[-1] == first[-1] == 0.5


def test_padding_rests_at_the_end():
    start = Waypoint(np.zeros(3), POINTING_DOWN, 0, 0.04)
    motion = motion_through(start, [Waypoint(np.ones(3), POINTING_DOWN, 0.1, 0.0)], 0.002)
    long = padded(motion, 80)
    np.testing.assert_array_equal(long.position[50:], np.ones((30, 3)))
    np.testing.assert_array_equal(long.twist[50:], 0)
