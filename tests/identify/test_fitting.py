import numpy as np
import pytest
from benchmarks.hidden_effects import effects as hidden
from benchmarks.hidden_effects.cases import ROBOTS
from benchmarks.hidden_effects.generator import record

from t2l.detective.candidates import settings_of
from t2l.effects.registry import builtin
from t2l.effects.term import Layout, Term
from t2l.identify.first_guesses import first_guesses
from t2l.identify.fitting import run, start_from_the_best
from t2l.identify.least_squares import LeastSquares
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor
from t2l.identify.scales import sized
from t2l.recordings import Recording
from tests.diagnose.made import measured, pendulum, read, recording, swing, swings, two_pendulums


def fitted(recordings, names, adopted=None, iterations=15, diagonal=False):
    """{effect: fit from the best of its own first guesses}."""
    robot = recordings[0].robot
    predictor = Predictor(robot, recordings, threads=1)
    mask, njoint = np.ones(len(predictor.samples), bool), len(predictor.joints)
    model = sized(Model(robot, adopted or {}), predictor)
    layout, u = model.vector(predictor.joints)
    effects = [model.known_effects(predictor.joints)[name] for name in names]
    seen = read(predictor, (layout, u), effects)
    guesses = {e.name: first_guesses(e, model.sizes, njoint) + seen[e.name] for e in effects}
    tried = dict(zip(names, settings_of(predictor, (layout, u), effects, guesses), strict=True))
    fits = {}
    for name, (whole, starts) in tried.items():
        stated = [max(slot.size, 1e-3 * slot.scale) for slot in whole.slots]
        size = np.maximum(np.median(np.abs(starts), axis=0), stated)
        fits[name] = LeastSquares(whole, starts[0], size, diagonal)
    starts = {name: settings for name, (_, settings) in tried.items()}
    start_from_the_best(fits, starts, predictor, mask)
    run(list(fits.values()), predictor, mask, iterations)
    return fits


def theta(fit):
    return fit.layout.theta(fit.u)


TRUTH = {
    "coulomb_friction": {"torque": 0.05},
    "viscous_friction": {"damping": 0.06},
    "armature": {"inertia": 0.01},
    "torque_constant": {"factor": 0.85},
    "torque_offset": {"torque": -0.08},
    "controller_gains": {"kp_factor": 0.9, "kd_factor": 1.3},
    "cogging": {"amplitude": 0.06, "phase": -0.5, "periods": 21.0},
}


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    return pendulum(tmp_path_factory.mktemp("robot"))


@pytest.mark.parametrize("name", TRUTH)
def test_what_made_the_data_is_found_again(robot, name):
    effects = {name: {k: {"hinge": v} for k, v in TRUTH[name].items()}}
    fit = fitted(swings(robot, effects, 2e-5, 1.0, control_rate_hz=500.0), [name])[name]
    assert theta(fit) == pytest.approx(list(TRUTH[name].values()), rel=0.03)
    assert np.sqrt(fit.loss) < 4e-5


@pytest.mark.parametrize(
    ("name", "truth"),
    [("command_delay", {"delay": 0.013}), ("command_filter", {"cutoff": 6.0})],
)
def test_a_number_of_the_robot_is_found_again(robot, name, truth):
    fit = fitted(swings(robot, {name: truth}, 2e-5, 1.0, control_rate_hz=500.0), [name])[name]
    assert theta(fit) == pytest.approx(list(truth.values()), rel=0.03)


def test_two_effects_are_fitted_together(robot):
    effects = {
        "coulomb_friction": {"torque": {"hinge": 0.05}},
        "command_delay": {"delay": 0.011},
    }
    wrong = {"coulomb_friction": {"torque": {"hinge": 0.02}}}
    recordings = swings(robot, effects, 2e-5, 1.0, control_rate_hz=500.0)
    fit = fitted(recordings, ["command_delay"], adopted=wrong)["command_delay"]
    found = fit.layout.decode(fit.u[None])
    assert found["coulomb_friction"]["torque"] == pytest.approx(0.05, rel=0.03)
    assert found["command_delay"]["delay"] == pytest.approx(0.011, rel=0.03)


@pytest.mark.parametrize("diagonal", [False, True])
def test_each_joint_has_its_own_parameter(tmp_path, diagonal):
    robot = two_pendulums(tmp_path)
    model = Model(robot, {"viscous_friction": {"damping": {"left": 0.05, "right": 0.2}}})

    def both(t):
        return np.stack([swing(0.5, 0.9)(t), swing(-0.4, 1.3)(t)], axis=1)

    made = measured(recording(robot, both, duration_s=0.8), noise_rad=1e-5, model=model)
    predictor = Predictor(robot, [made])
    layout = Layout([Term(builtin()["viscous_friction"], (0, 1))])
    fit = LeastSquares(layout, np.array([0.1, 0.1]), np.array([0.1, 0.1]), diagonal)
    run([fit], predictor, np.ones(len(predictor.samples), bool), 12)
    assert fit.u == pytest.approx([0.05, 0.2], rel=0.01)


def arm(effects, noise_rad=2e-5) -> list[Recording]:
    """A two-joint arm under its weight, in two postures far from hanging."""
    robot, made = ROBOTS["two_joint_arm"], []
    for index, (shoulder, elbow) in enumerate([(0.5, 2.2), (1.6, 1.9)]):

        def commands(t, shoulder=shoulder, elbow=elbow):
            return np.stack([swing(0.15, 0.9, shoulder)(t), swing(-0.2, 1.3, elbow)(t)], axis=1)

        plain = recording(
            str(robot.mjcf), commands, f"posture{index}", 40.0, 2.0, 1.0, joints=robot.joints
        )
        model = Model(str(robot.mjcf), effects)
        made.append(measured(plain, noise_rad=noise_rad, seed=index, model=model))
    return made


def test_an_encoder_offset_moves_the_other_joints_too():
    """Derivatives that move all joints at once would mistake the sum for each joint's own."""
    recordings = arm({"encoder_offset": {"offset": {"elbow": 0.03}}})
    predictor = Predictor(recordings[0].robot, recordings)
    layout = Layout([Term(builtin()["encoder_offset"], (0, 1))])
    fit = LeastSquares(layout, np.array([0.0, 0.0]), np.array([0.02, 0.02]), diagonal=True)
    run([fit], predictor, np.ones(len(predictor.samples), bool), 4)
    assert fit.u == pytest.approx([0.0, 0.03], abs=1e-4)


def test_the_centre_of_mass_of_a_payload_is_found():
    payload = {"mass": 0.3, "com_x": 0.02, "com_y": 0.0, "com_z": -0.04}
    fit = fitted(arm({"payload": payload}), ["payload"])["payload"]
    found = fit.layout.decode(fit.u[None])["payload"]
    for name in ("mass", "com_x", "com_z"):
        assert found[name] == pytest.approx(payload[name], rel=0.03), name


@pytest.mark.parametrize("diagonal", [False, True])
def test_a_ripple_is_read_off_though_the_joint_is_far_from_zero(diagonal):
    """Amplitude and phase: at 2 rad a sine and a cosine would turn with the periods."""
    ripple = {"amplitude": 0.15, "phase": 0.7, "periods": 27.0}
    recordings = arm({"cogging": {k: {"elbow": v, "shoulder": v} for k, v in ripple.items()}})
    fit = fitted(recordings, ["cogging"], diagonal=diagonal)["cogging"]
    found = fit.layout.decode(fit.u[None])["cogging"]
    assert found["amplitude"][0] == pytest.approx([0.15, 0.15], rel=0.02)
    assert found["periods"][0] == pytest.approx([27.0, 27.0], rel=0.005)


# ------------------------------------------------------- recordings that t2l had no part in


def generated(effect, seed=0) -> list[Recording]:
    robot, made = ROBOTS["pendulum"], []
    for index, (kp, kd) in enumerate(robot.setup.gains[:2]):
        hz = 0.8 + 0.3 * index
        frame = record(
            robot.mjcf, robot.joints, kp, kd, lambda t, hz=hz: swing(0.6, hz)(t)[:, None],
            duration_s=1.0, sample_rate_hz=100, hidden=[effect], physics_rate_hz=4000,
            encoder_noise_rad=1e-4, rng=np.random.default_rng([seed, index]),
        )  # fmt: skip
        made.append(
            Recording(
                name=f"kp{kp:g}", path=None, robot=str(robot.mjcf), joints=robot.joints,
                kp=np.array([kp]), kd=np.array([kd]), command_rate_hz=50.0,
                control_rate_hz=1000.0, gravity_compensation=False,
                time=frame["time"].to_numpy(), q_des=frame[["q_des.hinge"]].to_numpy(),
                q=frame[["q.hinge"]].to_numpy(),
            )
        )  # fmt: skip
    return made


@pytest.mark.parametrize(
    ("effect", "name", "truth"),
    [
        (hidden.CoulombFriction(0.06), "coulomb_friction", 0.06),
        (hidden.CommandDelay(0.014), "command_delay", 0.014),
    ],
)
def test_an_independent_machines_parameter_is_found(effect, name, truth):
    fit = fitted(generated(effect), [name])[name]
    assert theta(fit) == pytest.approx([truth], rel=0.05)
    assert np.sqrt(fit.loss) < 2e-4


def test_a_rough_parameter_is_left_alone(robot):
    recordings = swings(robot, {"low_rate_loop": {"rate": 200.0, "phase": 0.0}}, 1e-4, 0.8)
    fit = fitted(recordings, ["low_rate_loop"])["low_rate_loop"]
    assert theta(fit) == pytest.approx([200.0, 0.0], rel=1e-9)
    assert fit.done


def test_a_fit_is_the_same_alone_and_in_company(robot):
    effects = {"coulomb_friction": {"torque": {"hinge": 0.05}}}
    recordings = swings(robot, effects, 1e-4, 0.6, control_rate_hz=250.0)
    names = ["coulomb_friction", "viscous_friction", "command_delay"]
    together = fitted(recordings, names, iterations=4)
    for name in names[:2]:
        alone = fitted(recordings, [name], iterations=4)[name]
        np.testing.assert_allclose(alone.u, together[name].u, rtol=1e-9)
