import json

import numpy as np
import pytest

from t2l.advise import files, words
from t2l.advise.advice import Asked, advised, least, own_cells
from t2l.advise.exclusions import HOPELESS, KNOWN_MARGIN, LEAST_MARGIN, RINGS
from t2l.advise.grid import of
from t2l.advise.responses import settles_together
from t2l.advise.shown import of_dataset
from t2l.errors import ConfigurationError
from t2l.figures.advice import advice_maps, reasons
from t2l.identify.model import Model
from t2l.identify.prediction import with_effects
from t2l.robots.plant import position_ranges
from tests.advise.made import ARM, JOINTS, dataset

PLANT = with_effects(ARM, JOINTS)
RANGES = position_ranges(PLANT, JOINTS)
WIDE = of([3.0, 12.0, 50.0], [0.1, 0.5, 2.0, 8.0])


@pytest.fixture(scope="module")
def shown(tmp_path_factory):
    folder = dataset(tmp_path_factory.mktemp("shown") / "set")
    return of_dataset(folder, PLANT, JOINTS, RANGES, None, False)


def asked(shown=None, grid=WIDE, effects=None, **changes):
    said = dict(
        model=Model(ARM, effects or {}), joints=JOINTS, poses=np.array([[0.2, 0.3], [0.5, -0.4]]),
        grid=grid, units=np.ones((2, 2)), control_rate_hz=500.0, policy_rate_hz=25.0,
        compensated=True, ranges=RANGES, velocity_limit=np.full(2, np.inf),
        torque_limit=np.full(2, 5.0), shown=shown,
    )  # fmt: skip
    return Asked(**(said | changes))


@pytest.fixture(scope="module")
def advice(shown):
    return advised(asked(shown))


def test_what_is_advised_is_allowed_and_has_the_least_predicted_error(advice):
    may = advice.allowed.all(axis=1)
    assert may[advice.best]
    assert advice.score[advice.best] == advice.score[may].min()
    assert advice.own == ()
    cell = advice.asked.grid.cells[advice.best]
    assert advice.gains.tolist() == [[cell.kp, cell.kd]] * 2
    assert advice.as_good[advice.best]
    assert not (advice.as_good & ~may).any()


def test_the_chance_rises_with_the_factor(advice):
    order = np.argsort(advice.score)
    assert (np.diff(advice.chance()[order]) >= 0).all()


def test_demonstrations_are_followed_by_what_is_left(advice):
    errors = advice.cloning.replay.rmse_rad[advice.best]
    assert errors.max() < 0.05


def test_without_demonstrations_the_median_joint_is_damped_critically():
    found = advised(asked())
    assert found.cloning is None
    inertia = np.sort(found.machine.inertia.mean(axis=0))[1]
    cell = found.asked.grid.cells[found.best]
    zeta = cell.kd / (2 * np.sqrt(cell.kp * inertia))
    assert 0.4 < zeta < 2.5
    assert "nothing tells how stiff" in words.wants(found)[0]


def test_a_late_machine_is_given_less_damping(shown, advice):
    late = advised(asked(shown, effects={"torque_delay": {"delay": 0.012}}))
    assert (late.allowed.sum(axis=0) < advice.allowed.sum(axis=0)).any()
    assert any("12 ms late" in one.why for one in late.objections)


def test_a_joint_that_rules_the_cell_out_has_one_of_its_own():
    may = np.array([[True, False], [False, True], [True, False]])
    by_joint = np.array([[3.0, 1.0], [1.0, 2.0], [2.0, 1.0]])
    best = least(np.array([3.0, 2.0, 1.0]), np.ones(3, bool))
    assert best == 2
    assert own_cells(best, may, by_joint).tolist() == [2, 1]


def test_no_gains_that_hold_the_robot_are_refused_by_joint_and_reason():
    with pytest.raises(ConfigurationError, match=r"Kp 0\.5 to 1 .* hold (shoulder|elbow).*sags"):
        advised(asked(grid=of([0.5, 1.0], [0.3, 0.5]), compensated=False))


def test_the_files_say_what_is_advised(advice, tmp_path):
    files.write_advice(advice, tmp_path)
    content = json.loads((tmp_path / files.ADVICE).read_text())
    assert len(content["cells"]) == len(WIDE.cells)
    best = content["cells"][advice.best]
    assert best["as_good"]
    assert best["excluded"] == []
    assert best["predicted_error_rad"] == pytest.approx(advice.score[advice.best])
    assert content["joints"]["elbow"]["kp"] == best["kp"]
    text = (tmp_path / files.GAINS).read_text()
    assert f"kp: {best['kp']}" in text


def test_sentences_are_of_this_robot(advice):
    assert words.headline(advice).startswith("Kp ")
    told = " ".join(
        [words.as_good(advice), *words.wants(advice), *words.confidence(advice),
         *words.changes(advice, False)]
    )  # fmt: skip
    for part in ("elbow", "rank correlation", "per cent points", "t2l plan"):
        assert part in told
    assert not {"nan", "inf"} & set(told.lower().split())


def test_room_for_actions_is_told(advice):
    told = " ".join(words.trying(advice))
    assert "within the torque limits" in told or "more torque at once" in told
    assert "200 trainings of Joint-Reach" in told
    assert words.trying(advised(asked())) == []


def test_maps_have_a_panel_a_number(advice):
    assert sum(axes.get_visible() for axes in advice_maps(advice).axes if axes.images) == 7
    assert len(advice_maps(advised(asked())).axes) >= 3
    assert sum(bool(axes.images) for axes in reasons(advice).axes) == 2


def test_gains_of_each_joint_settle_together():
    """The elbow rules out what the shoulder needs: what is given to each is checked together."""
    late = {"torque_delay": {"delay": 0.02}}
    found = advised(asked(effects=late, grid=of([1.0, 3.0, 9.0], [0.05, 0.2, 0.8])))
    loop = found.asked.machine()
    assert settles_together(loop, *(gain[None] for gain in found.gains.T))[0]
    assert found.allowed[found.cells, np.arange(2)].all()


def test_what_rings_is_a_cost_where_demonstrations_weigh_it_and_rules_out_elsewhere(shown):
    grid = of([3.0, 50.0], [0.1, 2.0])
    weighed, alone = advised(asked(shown, grid=grid)), advised(asked(grid=grid))
    ringing = [one.cell for one in weighed.objections if one.kind == RINGS]
    assert ringing
    assert RINGS in {one.kind for one in weighed.costing}
    assert weighed.allowed.all(axis=1)[ringing].all()
    assert not alone.allowed.all(axis=1)[ringing].any()
    assert words.costs(weighed)
    assert not words.costs(alone)


def test_what_is_hopeless_by_prediction_is_left_by_nobody(shown):
    found = advised(asked(shown))
    worst = found.score >= HOPELESS * found.score[found.best]
    assert worst.any()
    assert not (found.left & worst).any()
    assert found.ruled_out[worst].all()


def test_a_machine_that_is_known_may_be_nearer_to_unstable(shown):
    late = {"torque_delay": {"delay": 0.008}}
    blind, knows = (advised(asked(shown, effects=late, known=known)) for known in (False, True))
    more = knows.allowed & ~blind.allowed
    margins = blind.responses.margin[more]
    assert len(margins)
    assert (margins >= KNOWN_MARGIN).all()
    assert (margins < LEAST_MARGIN).all()
    assert not (blind.allowed & ~knows.allowed).any()


def test_play_between_motor_and_link_is_left_out_of_the_linear_loop(shown):
    values = {"play": 0.01, "contact_time": 1e-3, "contact_damping": 0.1}
    play = {name: {"elbow": value} for name, value in values.items()} | {"encoder_on_link": 0.0}
    found = advised(asked(shown, effects={"backlash": play}))
    assert found.machine.left_out
    assert np.isfinite(found.score[found.best])
