import numpy as np
import pytest

from t2l.diagnose.evidence import gather
from t2l.diagnose.final_fit import fit_fully
from t2l.diagnose.racing import race
from t2l.effects.registry import builtin
from t2l.effects.term import Layout
from t2l.identify.model import Model
from tests.diagnose.made import measured, recording, swing, two_pendulums


def theta(fit):
    return fit.layout.theta(fit.u)


def test_a_joint_without_play_is_left_out(tmp_path):
    """Nor does it vote on the encoder's side, though every guess of a play harms it."""

    def both(t):
        return np.stack([swing(0.5, 0.9)(t), swing(-0.4, 1.3)(t)], axis=1)

    robot = two_pendulums(tmp_path)
    play = {"play": 0.03, "contact_time": 2e-3, "contact_damping": 0.3}
    values = {k: {"left": v} for k, v in play.items()} | {"encoder_on_link": 0.0}
    model = Model(robot, {"backlash": values})
    made = [recording(robot, both, name, kp, 0.8, 0.8) for name, kp in (("a", 10.0), ("b", 30.0))]
    recordings = [measured(r, noise_rad=1e-4, seed=i, model=model) for i, r in enumerate(made)]
    evidence, effects = gather(robot, recordings), [builtin()["backlash"]]
    fits = race(evidence, Layout(()), np.zeros(0), effects, lambda what, fraction: None)
    full = fit_fully(fits.fits, ["backlash"], evidence)["backlash"]
    assert full.layout.terms[0].joints == (0,)
    assert theta(full) == pytest.approx([0.03, 2e-3, 0.3, 0.0], rel=0.03)
