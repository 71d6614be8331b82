"""The linear model of the loop against the loop itself, and against algebra."""

import numpy as np
import pytest

from t2l.detective.linear_loop import linearised, respond
from t2l.detective.motion import measured_motion
from t2l.detective.responses import added_torques
from t2l.effects.registry import builtin
from t2l.effects.term import Layout, Term
from t2l.identify.first_guesses import first_guesses
from t2l.identify.prediction import Predictor, Request
from t2l.identify.scales import scales
from t2l.identify.simulation import install
from t2l.sim.driven_loop import DrivenLoop, all_at_once
from tests.diagnose.made import WEIGHT, hold, measured, pendulum, recording, swings

BARE = Layout(()), np.zeros(0)


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    return pendulum(tmp_path_factory.mktemp("robot"))


@pytest.fixture(scope="module")
def swinging(robot):
    predictor = Predictor(robot, swings(robot, noise_rad=1e-5), threads=1)
    return predictor, linearised(predictor, *BARE, measured_motion(predictor, *BARE))


def response(predictor, sections, layout, u):
    """Of a variant u (n,), by the linear model and by the simulation; (nsample,) rad each."""
    linear = np.empty(len(predictor.samples))
    for section in sections:
        (torque,) = added_torques(predictor, section, BARE, [(layout, u[None])])
        answer = respond(section, torque.transpose(0, 2, 3, 1))
        linear[section.motion.group.held] = answer[:, 0]
    (base,), (moved,) = predictor.predict([Request(*(BARE[0], BARE[1][None])),
                                           Request(layout, u[None])])  # fmt: skip
    return linear, moved - base


SMALL = {
    "armature": {"inertia": 1e-4},
    "viscous_friction": {"damping": 1e-3},
    "torque_offset": {"torque": 1e-3},
    "torque_constant": {"factor": 1.001},
    "controller_gains": {"kp_factor": 1.002, "kd_factor": 0.998},
    "command_delay": {"delay": 5e-4},
    "payload": {"mass": 1e-4, "com_x": 0.0, "com_y": 0.0, "com_z": 0.0},
    "link_inertia": {
        "mass_factor": 1.001, "com_x": 0.0, "com_y": 0.0, "com_z": -1e-4, "inertia_factor": 1.0,
    },
    "base_tilt": {"roll": 0.0, "pitch": 1e-3},
    "parallel_spring": {"stiffness": 1e-3, "rest": 0.1},
    "velocity_filter": {"cutoff": 300.0},
    "actuator_bandwidth": {"cutoff": 300.0},
}  # fmt: skip


@pytest.mark.parametrize("name", SMALL)
def test_a_small_change_moves_the_loop_as_the_linear_model_says(swinging, name):
    predictor, sections = swinging
    layout = Layout([Term(builtin()[name], (0,))])
    u = layout.encode({name: {key: np.array([value]) for key, value in SMALL[name].items()}})
    linear, simulated = response(predictor, sections, layout, u)
    size = np.sqrt(np.mean(simulated**2))
    assert size > 1e-6
    assert np.sqrt(np.mean((linear - simulated) ** 2)) < 0.06 * size


def test_at_rest_a_torque_turns_the_joint_by_itself_over_the_stiffness(robot):
    still = measured(recording(robot, hold(0.0), duration_s=2.0))
    predictor = Predictor(robot, [still], threads=1)
    (section,) = linearised(predictor, *BARE, measured_motion(predictor, *BARE))
    torque = np.full((*section.path.q.shape[:2], 1), 0.01)
    answer = respond(section, torque, np.array([0]))
    stiffness = still.kp[0] + WEIGHT  # a pendulum that hangs is a spring itself
    assert answer[-1, 0] == pytest.approx(0.01 / stiffness, rel=1e-3)


@pytest.mark.parametrize(
    "name", [name for name, effect in builtin().items() if not effect.remembers]
)
def test_what_remembers_nothing_needs_no_order_of_ticks(swinging, name):
    predictor, (section,) = swinging[0], swinging[1]
    effect = builtin()[name]
    if not effect.may_act(predictor.recordings):
        pytest.skip("it needs a column, or more joints")
    layout = Layout([Term(effect, (0,))])
    guess = first_guesses(effect, scales(predictor), 1)[0]
    variant = layout, layout.encode({name: guess})[None]
    model, schedule = predictor.model(layout.terms), section.motion.group.schedule
    in_turn = DrivenLoop(model, predictor.joints, schedule, 1)
    at_once = DrivenLoop(model, predictor.joints, all_at_once(schedule, len(section.path.q)), 1)
    for loop in (in_turn, at_once):
        install(loop, [variant])
    one = in_turn.torque(section.path)[:, 0]
    other = at_once.torque(section.path.all_at_once())[0, 0]
    assert np.allclose(one, other.reshape(one.shape), atol=1e-12)


@pytest.mark.parametrize("name", sorted(builtin()))
def test_ticks_in_blocks_are_as_ticks_in_turn(swinging, name, monkeypatch):
    predictor, (section, *_) = swinging
    layout = Layout([Term(builtin()[name], (0,))])
    model, schedule = predictor.model(layout.terms), section.motion.group.schedule
    (guess, *_) = first_guesses(builtin()[name], scales(predictor), 1)
    u = layout.encode({name: guess})[None]
    if model.nv > 1 or not builtin()[name].may_act(predictor.recordings):
        pytest.skip("it cannot be led along a motion of a pendulum")

    def torque():
        loop = DrivenLoop(model, predictor.joints, schedule, 1)
        install(loop, [(layout, u)])
        return loop.torque(section.path)

    in_blocks = torque()
    monkeypatch.setattr("t2l.sim.driven_loop.BLOCK", 1)
    assert np.allclose(in_blocks, torque(), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("so_far", [(), ("dahl_friction",)])
def test_variants_together_are_each_what_they_are_alone(swinging, so_far, monkeypatch):
    predictor, sections = swinging
    effects, sizes = builtin(), scales(predictor)

    def layout_and_u(names, which=0):
        layout = Layout([Term(effects[name], (0,)) for name in names])
        guesses = {name: first_guesses(effects[name], sizes, 1) for name in names}
        return layout, layout.encode({n: some[which % len(some)] for n, some in guesses.items()})

    base = layout_and_u(so_far)
    variants = []
    for name in ("lugre_friction", "link_inertia", "encoder_scale", "cogging", "command_delay"):
        (layout, u), (_, other) = (layout_and_u((*so_far, name), which) for which in (0, 1))
        variants.append((layout, np.stack([u, other])))
    together = added_torques(predictor, sections[0], base, variants)
    # pieces of other sizes
    monkeypatch.setattr("t2l.detective.responses.ROWS", 700)
    for (layout, u), torque in zip(variants, together, strict=True):
        for row, values in enumerate(u):
            alone = added_torques(predictor, sections[0], base, [(layout, values[None])])[0][:, 0]
            assert np.abs(alone).max() > 0
            scale = np.abs(alone).max()
            np.testing.assert_allclose(torque[:, row] / scale, alone / scale, atol=1e-5)
