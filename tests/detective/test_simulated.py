"""Effects that can only be simulated, in the screen."""

import numpy as np
import pytest

from t2l.detective.candidates import known_candidates
from t2l.detective.linear_loop import linearised
from t2l.detective.motion import measured_motion
from t2l.effects.registry import builtin
from t2l.effects.term import Layout
from t2l.identify.first_guesses import first_guesses
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor, Request
from t2l.identify.scales import sized
from tests.diagnose.made import measured, recording, swing, two_pendulums

BARE = Layout(()), np.zeros(0)
PLAY = {
    "play": {"right": 0.03},
    "contact_time": {"right": 3e-3},
    "contact_damping": {"right": 0.2},
    "encoder_on_link": 0.0,
}


@pytest.fixture(scope="module")
def predictor(tmp_path_factory):
    """Of two joints of which one has play, in a log that begins in motion."""
    robot = two_pendulums(tmp_path_factory.mktemp("robot"))

    def commands(t):
        return np.column_stack([swing(0.5, 0.9)(t + 0.4), swing(0.5, 1.1)(t + 0.4)])

    one = recording(robot, commands, joints=("left", "right"), duration_s=2.0)
    return Predictor(robot, [measured(one, {"backlash": PLAY}, 1e-4)], threads=1)


def test_they_are_tried_on_joints_that_err_and_explain_what_they_hide(predictor):
    effects = [builtin()[name] for name in ("backlash", "viscous_friction")]
    sizes = sized(Model(predictor.robot), predictor).sizes
    guesses = {effect.name: first_guesses(effect, sizes, 2) for effect in effects}
    left = predictor.samples.q - predictor.predict([Request(BARE[0], BARE[1][None])])[0][0]
    sections = linearised(predictor, *BARE, measured_motion(predictor, *BARE))
    rows = np.arange(len(left))
    table = known_candidates(predictor, sections, BARE, effects, guesses, left, rows)
    of = {e.name: [c for c in table.candidates if c.effect.name == e.name] for e in effects}
    # what is led along the motion costs little
    assert {c.joints for c in of["viscous_friction"]} == {(0,), (1,), (0, 1)}
    assert {c.joints for c in of["backlash"]} == {(1,)}
    response = table.columns[:, of["backlash"][0].constants[0]].astype(float)
    assert np.sum((left - response) ** 2) < 0.2 * np.sum(left**2)
