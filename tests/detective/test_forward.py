"""Sets that grow along the motion."""

import numpy as np
import pytest

from t2l.detective import forward
from t2l.detective import search as searching
from t2l.detective.along_motion import fit_along
from t2l.detective.data_split import split
from t2l.detective.fitted_set import Start
from t2l.detective.forward import growing
from t2l.detective.rule import Judge
from t2l.effects.term import Layout, Term
from t2l.identify.model import Model
from tests.diagnose.made import pendulum, swings

HIDDEN = {
    "joint_flexibility": {
        "stiffness": {"hinge": 60.0}, "damping": {"hinge": 0.2}, "encoder_on_link": 0.0,
    },
    "coulomb_friction": {"torque": {"hinge": 0.05}},
    "command_delay": {"delay": 0.02},
}  # fmt: skip


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    robot = pendulum(tmp_path_factory.mktemp("robot"))
    logs = swings(robot, HIDDEN, duration_s=2.0) + swings(robot, HIDDEN, duration_s=1.0)[1:2]
    return Model(robot), split(robot, logs, threads=1)


def begun(model, data):
    """A search that has linearised the loop, its screen, its judge and the model as it came."""
    searched = searching._Search(
        searching.sized(model, data.fitted), data, lambda this: None, lambda: False,
        searching.Offered(curves=False),
    )  # fmt: skip
    searched.begin(None)
    noise, came = searched.noise_rad(), searched.simulated
    searched._linearise(noise, came.known, came.rmse)
    left = searched._left(searched.current)
    screen = searched._screen(left, *searched._guesses(searched.current))
    return searched, screen, Judge(searched.block, noise), came


def test_from_nothing_they_grow_to_what_is_hidden(made, monkeypatch):
    """One effect a step, although no two steps add to the same set."""
    monkeypatch.setattr(forward, "STEPS", 3)  # so far it is quick
    model, data = made
    searched, screen, judge, came = begun(model, data)
    steps = growing(
        searched.current, [searched.current], screen, searched.rows, searched.along, data.folds,
        judge, 0.0,
    )  # fmt: skip
    every, best = zip(*steps, strict=True)
    sets = every[-1]
    assert [len(one.names) for one in best] == list(range(1, len(best) + 1))
    assert min(one.left_out_rmse for one in best) < 0.1 * came.left_out_rmse
    three = {name for name, _ in best[2].names}
    assert {"joint_flexibility", "command_delay"} < three
    # what did not lead on is kept too
    assert len(sets) > 20


def test_a_mimic_that_was_taken_early_gives_way_to_what_is_hidden(tmp_path):
    robot = pendulum(tmp_path)
    hidden = {name: HIDDEN[name] for name in ("coulomb_friction", "command_delay")}
    searched, screen, _, _ = begun(Model(robot), split(robot, swings(robot, hidden), threads=1))
    known = Model(robot).known_effects(("hinge",))
    mimic = Layout([Term(known[name], (0,)) for name in ("viscous_friction", "command_delay")])
    guess = {"viscous_friction": {"damping": 0.1}, "command_delay": {"delay": 0.01}}
    u = mimic.encode({
        name: {key: np.array([value]) for key, value in values.items()}
        for name, values in guess.items()
    })  # fmt: skip
    along, folds = searched.along, searched.data.folds
    (taken,) = fit_along([Start(mimic, u)], along, folds)
    others = forward._exchanged([taken], screen, searched.rows, along, folds, set())
    fits = fit_along(others, along, folds)
    assert not any(taken.names == one.names for one in fits)
    (true,) = (one for one in fits if {name for name, _ in one.names} == set(hidden))
    assert true.left_out_rmse < 0.5 * taken.left_out_rmse
