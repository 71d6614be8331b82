import numpy as np
import pytest

from t2l.diagnose.evidence import gather
from t2l.diagnose.pairs import fit_pairs, pairs_to_try
from t2l.effects.registry import builtin
from t2l.effects.term import Layout, Term
from t2l.identify.least_squares import LeastSquares
from tests.diagnose.made import measured, pendulum, recording, swing, swings, two_pendulums


def test_an_effect_that_some_joints_have_already_is_in_a_pair_once(tmp_path):
    robot = two_pendulums(tmp_path)
    made = recording(robot, lambda t: np.stack([swing()(t)] * 2, axis=1), duration_s=0.5)
    evidence = gather(robot, [measured(made)])
    coulomb, viscous = builtin()["coulomb_friction"], builtin()["viscous_friction"]
    alone = Layout([Term(coulomb, (0,)), Term(viscous, (0, 1))])
    wider = Layout([Term(coulomb, (0, 1))])
    fits = {
        "viscous_friction": LeastSquares(alone, np.full(len(alone), 0.01), np.ones(len(alone))),
        "coulomb_friction": LeastSquares(wider, np.array([0.01, 0.02]), np.ones(2)),
    }
    names = ("viscous_friction", "coulomb_friction")
    pair = fit_pairs([names], fits, evidence, False, 1e-12)[names]
    keys = [slot.key for slot in pair.layout.slots]
    assert len(set(keys)) == len(keys) == 4
    assert {term.effect.name: term.joints for term in pair.layout.terms} == {
        "coulomb_friction": (0, 1), "viscous_friction": (0, 1),
    }  # fmt: skip


def test_an_effect_that_leaves_far_less_than_any_other_is_tried_with_none():
    def tried(*losses, before):
        names = "abcdefg"[: len(losses)]
        fits = {name: LeastSquares(Layout(()), np.zeros(0), np.zeros(0)) for name in names}
        for fit, loss in zip(fits.values(), losses, strict=True):
            fit.loss = loss
        return pairs_to_try(fits, before)

    assert tried(1, 6, 6, 7, 8, 9, before=30) == []
    # much is left, or others leave as little
    assert len(tried(1, 6, 6, 7, 8, 9, before=15)) == 6
    assert len(tried(1, 3, 6, 7, 8, 9, before=30)) == 6
    assert tried(1, before=30) == []


def test_a_pair_starts_with_one_alone_where_the_other_was_fitted_astray(tmp_path):
    """Friction that holds the joint fast has no derivative that would lead away from it."""
    effects = {
        "torque_offset": {"torque": {"hinge": -0.4}},
        "coulomb_friction": {"torque": {"hinge": 0.05}},
    }
    recordings = swings(pendulum(tmp_path), effects, 2e-5, 1.0)
    evidence = gather(recordings[0].robot, recordings)
    fits = {}
    for name, value in (("torque_offset", -0.39), ("coulomb_friction", 8.0)):
        layout = Layout([Term(builtin()[name], (0,))])
        fits[name] = LeastSquares(layout, np.array([value]), np.array([0.1]))
    names = ("coulomb_friction", "torque_offset")
    pair = fit_pairs([names], fits, evidence, False, 1e-12)[names]
    assert np.sqrt(pair.loss) < 4e-5
    found = pair.layout.decode(pair.u[None])
    assert found["torque_offset"]["torque"] == pytest.approx(-0.4, rel=0.02)
    assert found["coulomb_friction"]["torque"] == pytest.approx(0.05, rel=0.02)
