import dataclasses

import numpy as np
import pytest

from t2l.identify.model import Model
from t2l.identify.noise_floor import noise_floor
from t2l.identify.prediction import Predictor, Request
from t2l.identify.step_size import NEGLIGIBLE, busiest, coarseness_for, substeps_for
from tests.diagnose.made import measured, pendulum, predict, recording, swing, swings

FRICTION = {"coulomb_friction": {"torque": {"hinge": 0.05}}}


@pytest.fixture
def recordings(tmp_path):
    return swings(pendulum(tmp_path), FRICTION, 1e-4, 0.5, control_rate_hz=125.0)


@pytest.mark.parametrize("effects", [{}, FRICTION], ids=["smooth", "dry friction"])
def test_steps_are_as_fine_as_the_noise_asks_for(recordings, effects):
    """Their error, twice what halving them changes, is small beside it; longer ones' is not."""
    model = Model(recordings[0].robot, effects)
    chosen = substeps_for(model, recordings)
    floor = noise_floor(recordings)

    def change(substeps):
        coarse, fine = (predict(recordings, effects, n) for n in (substeps, 2 * substeps))
        return np.sqrt(np.mean((coarse - fine) ** 2))

    assert 2 * change(chosen) < NEGLIGIBLE * floor
    assert chosen == 1 or 2 * change(chosen // 2) >= NEGLIGIBLE * floor


def test_dry_friction_takes_finer_steps(recordings):
    plain, sticky = (Model(recordings[0].robot, effects) for effects in ({}, FRICTION))
    assert substeps_for(plain, recordings) < substeps_for(sticky, recordings)


def test_much_noise_allows_coarse_steps(recordings):
    noise = np.random.default_rng(0)
    noisy = [
        dataclasses.replace(r, q=r.q + 1e-2 * noise.normal(size=r.q.shape)) for r in recordings
    ]
    assert substeps_for(Model(recordings[0].robot, FRICTION), noisy) == 1


def test_of_a_long_recording_the_busiest_part_is_looked_at(tmp_path):
    made = recording(pendulum(tmp_path), lambda t: swing()(t) * (t > 4)[:, None], duration_s=6.0)
    assert busiest(made, 6.0) is made
    part = busiest(made, 1.0)
    assert part.time[-1] > 4.0
    assert part.duration_s <= 1.0
    assert part.q_des.std() > 0.05
    # where nothing was measured there is nothing to look at
    q = np.where(made.time[:, None] > 4, np.nan, 0.0)
    assert busiest(dataclasses.replace(made, q=q), 1.0).time[0] < 4.0


def fast(folder, noise_rad, **gains):
    made = recording(pendulum(folder), swing(), duration_s=1.0, control_rate_hz=10000.0, **gains)
    return [measured(made, FRICTION, noise_rad)]


def test_a_fast_loop_ticks_once_a_millisecond_where_that_is_no_difference(tmp_path):
    logs = fast(tmp_path, 1e-4)
    model = Model(logs[0].robot, FRICTION)
    assert coarseness_for(model, logs, 1) == 10
    real, coarse = (
        Predictor(model.robot, logs, coarseness=n).predict([Request(*variant(model))])[0][0]
        for n in (1, 10)
    )
    assert np.sqrt(np.mean((real - coarse) ** 2)) < NEGLIGIBLE * noise_floor(logs)


def test_a_fast_loop_keeps_its_ticks_where_the_encoder_tells_the_difference(tmp_path):
    logs = fast(tmp_path, 1e-9, kp=400.0, kd=8.0)
    assert coarseness_for(Model(logs[0].robot), logs, 1) == 1


def test_a_loop_that_is_not_fast_keeps_its_ticks(recordings):
    assert coarseness_for(Model(recordings[0].robot), recordings, 1) == 1


def variant(model):
    layout, u = model.vector(("hinge",))
    return layout, u[None]
