import numpy as np
import pytest

from t2l.diagnose.evidence import gather
from t2l.diagnose.racing import fit_all, fit_fully
from t2l.effects.registry import builtin
from t2l.effects.term import Layout, Term
from t2l.identify.least_squares import LeastSquares
from t2l.identify.model import Model
from tests.diagnose.made import measured, pendulum, recording, swing, swings


def theta(fit):
    return fit.layout.theta(fit.u)


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    return pendulum(tmp_path_factory.mktemp("robot"))


def test_play_is_found_though_the_error_has_many_dents(robot):
    """From this start derivatives alone end in one of 0.13 mrad."""
    truth = {"play": 0.03, "contact_time": 1e-3, "contact_damping": 0.1}
    values = {k: {"hinge": v} for k, v in truth.items()} | {"encoder_on_link": 0.0}
    model = Model(robot, {"backlash": values})
    made = [recording(robot, swing(0.5, hz), f"{kp}", kp) for kp, hz in ((10.0, 0.9), (30.0, 1.3))]
    recordings = [measured(r, noise_rad=1e-4, seed=i, model=model) for i, r in enumerate(made)]
    evidence, layout = gather(robot, recordings), Layout([Term(builtin()["backlash"], (0,))])
    off = {"play": 0.0306, "contact_time": 6.5e-4, "contact_damping": 0.06, "encoder_on_link": 0.0}
    start = LeastSquares(layout, layout.encode({"backlash": off}), np.ones(4))
    full = fit_fully({"backlash": start}, ["backlash"], evidence)["backlash"]
    assert np.sqrt(full.loss) < 1.05e-4
    assert theta(full) == pytest.approx([0.03, 1e-3, 0.1, 0.0], rel=0.1)


# those that no optional column of a log drives
ALWAYS = sorted(name for name, effect in builtin().items() if not effect.needs)


@pytest.mark.parametrize("name", ALWAYS)
def test_every_effect_can_be_fitted_fully_to_a_single_joint(robot, name):
    evidence, effects = gather(robot, swings(robot, {}, 1e-4, 0.4)), [builtin()[name]]
    fits = fit_all(evidence, Layout(()), np.zeros(0), effects, 1e-4, lambda what, fraction: None)
    full = fit_fully(fits.fits, [name], evidence)[name]
    assert full.loss <= 1.1 * fits.fits[name].loss
    assert full.layout.terms[0].joints == (0,)
