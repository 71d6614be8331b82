import dataclasses

import numpy as np
import pytest

from t2l.identify.model import Model
from t2l.identify.noise_floor import noise_floor
from t2l.identify.step_size import NEGLIGIBLE, busiest, substeps_for
from tests.diagnose.made import pendulum, predict, recording, swing, swings

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


def test_rows_at_uneven_times_do_not_pass_for_noise(recordings):
    """Differences of such a motion do not vanish; of what the model leaves they do."""
    kept = np.random.default_rng(0).random(len(recordings[0].time)) < 0.5
    uneven = [dataclasses.replace(r, q=np.where(kept[:, None], r.q, np.nan)) for r in recordings]
    assert noise_floor(uneven) > 3 * noise_floor(recordings)
    model = Model(recordings[0].robot, FRICTION)
    assert substeps_for(model, uneven) >= substeps_for(model, recordings) > 1


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
