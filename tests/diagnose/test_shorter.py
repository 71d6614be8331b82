import numpy as np
import pytest

from t2l.diagnose.evidence import gather
from t2l.diagnose.shorter import SCREENED_S, shorter
from t2l.effects.term import Layout
from t2l.identify.model import Model
from t2l.identify.prediction import Request
from tests.diagnose.made import measured, pendulum, recording, swing, two_pendulums

SLOW = {"control_rate_hz": 250.0}


def sticky(made):
    """A recording of what has more friction than its model."""
    damping = {joint: 0.05 for joint in made.joints}
    return measured(made, {"viscous_friction": {"damping": damping}}, 1e-4)


def shortened(robot, evidence):
    return shorter(evidence, *Model(robot).vector(evidence.train.joints))


@pytest.mark.parametrize("duration_s", [7.0, 12.0])
def test_a_long_recording_is_screened_by_its_beginning(tmp_path, duration_s):
    robot = pendulum(tmp_path)
    made = sticky(recording(robot, swing(), duration_s=duration_s, **SLOW))
    evidence = gather(robot, [made])
    found = shortened(robot, evidence)
    if duration_s < 1.5 * SCREENED_S:
        assert found is evidence
        return
    assert (found.train, found.holdout) == (evidence.train, evidence.holdout)
    assert found.shortlist is found.screen
    samples = found.screen.samples
    assert samples.time.max() == pytest.approx(SCREENED_S - 0.01)
    # the same samples of the same blocks, and the same motion
    early = evidence.train.samples.time < SCREENED_S
    np.testing.assert_array_equal(samples.q, evidence.train.samples.q[early])
    np.testing.assert_array_equal(found.screen_mask, evidence.train_mask[early])
    plain = [Request(Layout(()), np.zeros((1, 0)))]
    (part,), (whole,) = found.screen.predict(plain), evidence.train.predict(plain)
    np.testing.assert_array_equal(part[0], whole[0, early])


def test_what_shows_only_later_is_not_cut_off(tmp_path):
    """One joint after the other: the first seconds know nothing of the second one."""
    robot = two_pendulums(tmp_path)

    def one_by_one(t):
        early = t < 5.0
        left, right = swing(0.5, 0.9)(t), swing(-0.4, 1.3)(t)
        return np.stack([np.where(early, left, 0.0), np.where(early, 0.0, right)], axis=1)

    made = sticky(recording(robot, one_by_one, duration_s=10.0, **SLOW))
    evidence = gather(robot, [made])
    assert shortened(robot, evidence) is evidence


def test_what_is_shortlisted_stays_whole_where_it_is_more(tmp_path):
    robot = pendulum(tmp_path)
    made = [
        sticky(recording(robot, swing(), f"kp{kp:g}", kp, duration_s=8.0, **SLOW))
        for kp in (5.0, 10.0, 20.0, 40.0)
    ]
    evidence = gather(robot, made[:3], made[3:])
    found = shortened(robot, evidence)
    assert found.shortlist is evidence.shortlist
    assert found.screen.recordings[0].duration_s == pytest.approx(SCREENED_S - 0.01)
