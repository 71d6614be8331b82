import numpy as np
import pytest

from t2l.recordings.importers.trajectories import Point, held_commands


def point(since, at, position, velocity=None):
    velocity = None if velocity is None else np.array([velocity])
    return Point(since, at, np.array([position]), velocity)


def test_streamed_positions_are_held_as_they_come():
    points = [point(t, t, q) for t, q in ((0, 1.0), (0.1, 2.0))]
    time, command = held_commands(points, [0.0], 50, 9.0)
    assert time.tolist() == [0.0, 0.1]
    assert command[:, 0].tolist() == [1.0, 2.0]


def test_between_points_the_controller_moves_in_a_straight_line():
    time, command = held_commands([point(0.0, 0.5, 1.0), point(0.0, 1.0, 1.0)], [0.0], 10, 9.0)
    assert time == pytest.approx(np.arange(10) / 10)
    assert command[:5, 0] == pytest.approx([0.2, 0.4, 0.6, 0.8, 1.0])
    assert command[5:, 0] == pytest.approx(1.0)


def test_velocities_make_a_cubic():
    points = [point(0.0, 0.0, 0.0, 0.0), point(0.0, 1.0, 1.0, 0.0)]
    time, command = held_commands(points, [0.0], 100, 9.0)
    half = np.argmin(np.abs(command[:, 0] - 0.5))
    assert np.gradient(command[:, 0], time)[half] == pytest.approx(1.5, abs=0.05)


def test_a_new_message_replaces_what_is_left_of_the_one_before():
    points = [point(0.0, 1.0, 1.0), point(0.5, 1.0, 0.5)]
    time, command = held_commands(points, [0.0], 10, 9.0)
    assert (np.diff(time) > 0).all()
    assert command[time < 0.45, 0] == pytest.approx([0.1, 0.2, 0.3, 0.4, 0.5])
    assert command[time >= 0.45, 0] == pytest.approx(0.5)


def test_what_comes_after_the_end_is_not_computed():
    points = [point(0.0, 1e6, 1e6), point(0.0, 2e9, 2e9)]
    time, command = held_commands(points, [0.0], 10, 1.0)
    assert time == pytest.approx(np.arange(10) / 10)
    assert command[:, 0] == pytest.approx(np.arange(1, 11) / 10)
    # but for the first
    time, _ = held_commands(points, [0.0], 10, -1.0)
    assert time.tolist() == [0.0]
