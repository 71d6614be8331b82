import numpy as np
import pytest

from t2l.advise.shown import COMMANDED, FREE, RECORDED, free_torques, of_dataset, of_task
from t2l.demos.other_gains import Gains
from t2l.errors import RecordingError
from t2l.identify.model import Model
from t2l.identify.prediction import with_effects
from t2l.robots.plant import position_ranges
from tests.advise.made import ARM, JOINTS, dataset, motion

MODEL = with_effects(Model(ARM).robot, JOINTS)
RANGES = position_ranges(MODEL, JOINTS)


def read(folder, gains=None, weighs=False, **options):
    return of_dataset(folder, MODEL, JOINTS, RANGES, gains, weighs, **options)


def test_of_demonstrations_torques_are_those_of_the_expert(task, demonstrations):
    shown = of_task(task, demonstrations)
    assert shown.torques == RECORDED
    assert shown.rate_hz == 500
    np.testing.assert_array_equal(shown.torque[0], demonstrations[0].torque)
    assert shown.poses(4).shape == (4, 7)


def test_a_data_set_tells_torques_by_commands_and_gains(tmp_path):
    shown = read(dataset(tmp_path / "set"), Gains(50.0, 0.0))
    assert shown.torques == COMMANDED
    assert shown.torque[0] == pytest.approx(np.tile([1.0, -0.5], (200, 1)))


def test_or_else_they_are_those_of_a_free_motion(tmp_path):
    shown = read(dataset(tmp_path / "set"))
    assert shown.torques == FREE
    # the arm begins and ends at rest
    assert np.abs(shown.torque[0][[0, -1]]).max() < 0.02
    weighs = read(tmp_path / "set", weighs=True)
    assert np.abs(weighs.torque[0][0]).max() > 0.2


def test_free_torques_move_the_arm_as_shown():
    """Half the torques of twice the time, squared: a motion scaled in time, without damping."""
    plain = with_effects(Model(ARM).robot, JOINTS)
    plain.dof_damping[:] = 0.0
    found = []
    for seconds in (2.0, 4.0):
        q = motion(0, 500.0, seconds)
        (torque,) = free_torques(
            plain, JOINTS, [q], [np.gradient(q, 0.002, axis=0)], 500.0, weighs=False
        )
        found.append(np.abs(torque).max(axis=0))
    assert found[0] / found[1] == pytest.approx([4, 4], rel=0.03)


def test_degrees(tmp_path):
    turned = dataset(tmp_path / "set", motions=lambda *args: np.rad2deg(motion(*args)))
    assert read(turned, degrees=True).q[0] == pytest.approx(motion(0))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"joints": ("hip", "knee")}, "shoulder among them.*another robot"),
        ({"count": 1}, "found 1; allowed: 2 or more"),
        ({"motions": lambda i, hz: np.add(motion(i, hz), [3, 0])}, "joint shoulder.*by the joint"),
        ({"motions": lambda i, hz: motion(i, hz)[:10]}, "found 10 frames; allowed: 0.2 s"),
        ({"motions": lambda i, hz: np.full((200, 2), np.nan)}, "no finite"),
    ],
)  # fmt: skip
def test_what_is_no_set_of_demonstrations_of_this_robot_is_refused(tmp_path, change, message):
    with pytest.raises(RecordingError, match=message):
        read(dataset(tmp_path / "set", **change))
