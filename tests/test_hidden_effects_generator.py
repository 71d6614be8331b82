"""The physics and the files of benchmarks/hidden_effects, against equations written here."""

import dataclasses

import mujoco
import numpy as np
import pandas as pd
import pytest
import yaml
from benchmarks import proposals
from benchmarks.hidden_effects import effects as fx
from benchmarks.hidden_effects import real_effects as rx
from benchmarks.hidden_effects.cases import ROBOTS, cases, is_complete, make, recording, scaled
from benchmarks.hidden_effects.drawn_robots import NAMES, cases_on_robots, settles
from benchmarks.hidden_effects.generator import Logger, Machine, record, write
from scipy.integrate import solve_ivp

from t2l.effects.registry import builtin

MASS, LENGTH, ARMATURE, DAMPING, GRAVITY = 0.5, 0.25, 0.005, 0.02, 9.81
INERTIA = MASS * LENGTH**2 + 1e-4 + ARMATURE
WEIGHT = MASS * GRAVITY * LENGTH
KP, KD = 20.0, 0.8
JOINTS = ("hinge",)

ARM = ROBOTS["two_joint_arm"]
FR3 = ROBOTS["fr3"]


@pytest.fixture
def pendulum(tmp_path):
    """A pendulum whose equation fits on a line."""
    path = tmp_path / "pendulum.xml"
    path.write_text(
        f"""<mujoco><compiler angle="radian"/><worldbody><body>
        <joint name="hinge" axis="0 1 0" armature="{ARMATURE}" damping="{DAMPING}"/>
        <inertial pos="0 0 {-LENGTH}" mass="{MASS}" diaginertia="1e-4 1e-4 1e-4"/>
        <site name="attachment_site" pos="0 0 {-LENGTH}"/>
        </body></worldbody></mujoco>"""
    )
    return path


def sine(t):
    return 0.6 * np.sin(2 * np.pi * 0.8 * t)[:, None]


def held(*position):
    return lambda t: np.tile(position, (len(t), 1))


def run(mjcf, q_des=sine, *hidden, kp=KP, kd=KD, joints=JOINTS, duration_s=1.0, **settings):
    settings = {"sample_rate_hz": 1000} | settings
    frame = record(mjcf, joints, kp, kd, q_des, duration_s=duration_s, hidden=hidden, **settings)
    return frame[[f"q.{j}" for j in joints]].to_numpy().squeeze()


@pytest.mark.parametrize("control_rate_hz", [1000, 250])
def test_a_clean_recording_solves_the_pendulums_equation(pendulum, control_rate_hz):
    state, expected = np.zeros(2), []
    for tick in range(control_rate_hz):
        command = sine(np.array([tick * 50 // control_rate_hz / 50]))[0, 0]
        torque = KP * (command - state[0]) - KD * state[1]

        def motion(_, x, torque=torque):
            gravity = MASS * GRAVITY * LENGTH * np.sin(x[0])
            return x[1], (torque - gravity - DAMPING * x[1]) / INERTIA

        expected.append(state[0])
        state = solve_ivp(motion, (0, 1 / control_rate_hz), state, rtol=1e-9, atol=1e-12).y[:, -1]
    q = run(pendulum, control_rate_hz=control_rate_hz, sample_rate_hz=control_rate_hz)
    np.testing.assert_allclose(q, expected, atol=1e-8)


@pytest.mark.parametrize(
    "identity",
    [
        fx.Armature(0.0),
        fx.TorqueConstant(1.0),
        fx.ControllerGains(),
        fx.CommandDelay(0.0),
        fx.ActuatorBandwidth(np.inf),
        fx.TorqueRateLimit({}),
        fx.TorqueSaturation(1e3),
        fx.LowRateLoop(1000),
        fx.EncoderOffset(0.0),
        fx.CoulombFriction(0.0),
        fx.LoadDependentFriction(0.0),
        fx.HysteresisTorque(0.0, 0.1),
        fx.JointFlexibility({}, 0.0),
        fx.Backlash({}),
    ],
    ids=lambda e: type(e).__name__,
)
def test_an_effect_of_no_magnitude_changes_nothing(pendulum, identity):
    clean = run(pendulum, duration_s=0.2)
    np.testing.assert_allclose(run(pendulum, sine, identity, duration_s=0.2), clean, atol=1e-12)


@pytest.mark.parametrize("split", [fx.JointFlexibility(2e4, 2.0), fx.Backlash(1e-9)])
def test_a_rigid_transmission_gives_the_nominal_joint_back(pendulum, split):
    np.testing.assert_allclose(run(pendulum, sine, split), run(pendulum), atol=1e-3)


@pytest.mark.parametrize(
    "friction", [fx.CoulombFriction(0.1), fx.LoadDependentFriction(0.0, 0.1)], ids=["dry", "gear"]
)
def test_friction_sticks_without_creep(pendulum, friction):
    """Commands worth half of the friction's level do not move a joint at rest."""

    def step(t):
        return np.where(t > 0.1, 0.05 / KP, 0.0)[:, None]

    q = run(pendulum, step, friction, duration_s=1.5)
    assert np.abs(q).max() < 1e-5
    assert np.abs(q[1000:] - q[1000]).max() < 1e-9


def test_friction_dissipates_its_level_times_the_way(pendulum):
    """A free swing loses the energy that Coulomb and viscous friction take."""
    level = 0.05
    machine = Machine(pendulum, JOINTS, [fx.CoulombFriction(level)], 8000, False, np.array([1.0]))

    def energy():
        q, v = machine.data.qpos[0], machine.data.qvel[0]
        return 0.5 * INERTIA * v**2 - MASS * GRAVITY * LENGTH * np.cos(q)

    before, way, viscous = energy(), 0.0, 0.0
    for _ in range(8000):
        q, v = machine.data.qpos[0], machine.data.qvel[0]
        machine.step()
        way += abs(machine.data.qpos[0] - q)
        viscous += DAMPING * v**2 / 8000
    assert before - energy() == pytest.approx(level * way + viscous, rel=5e-3)


def test_a_spring_between_rotor_and_link_conserves_energy(pendulum):
    pendulum.write_text(pendulum.read_text().replace(f'damping="{DAMPING}"', ""))
    k = 50.0
    spring = fx.JointFlexibility(k, 0.0)
    machine = Machine(pendulum, JOINTS, [spring], 8000, False, np.array([0.5]))
    link, rotor = (machine.model.joint(name).id for name in ("hinge", "hinge_rotor"))
    machine.data.qvel[rotor] = 5.0

    def energy():
        q, v = machine.data.qpos, machine.data.qvel
        kinetic = 0.5 * (INERTIA - ARMATURE) * v[link] ** 2 + 0.5 * ARMATURE * v[rotor] ** 2
        spring = 0.5 * k * (q[rotor] - q[link]) ** 2
        return kinetic + spring - MASS * GRAVITY * LENGTH * np.cos(q[link])

    before = energy()
    for _ in range(8000):
        machine.step()
    assert energy() - before == pytest.approx(0, abs=1e-3 * 0.5 * ARMATURE * 5.0**2)


def test_a_payload_sags_by_its_own_weight():
    """Under perfect compensation of the arm, the motors' springs carry the payload alone."""
    mass, kp, home = 0.2, np.array([40.0, 15.0]), (0.4, 0.8)
    q = run(
        ARM.mjcf,
        held(*home),
        fx.Payload(mass, com=(0.0, 0.0, -0.05)),
        kp=kp,
        kd=(2, 0.6),
        joints=ARM.joints,
        duration_s=0.1,
        gravity_compensation=True,
    )[-1]
    elbow = 0.35 * np.sin(q[0] + q[1])  # levers about the joints; both turn towards gravity
    shoulder = 0.3 * np.sin(q[0]) + elbow
    sag = mass * GRAVITY * np.array([shoulder, elbow]) / kp
    np.testing.assert_allclose(np.array(home) - q, sag, atol=1e-5)


def test_the_compensated_fr3_holds_its_pose_exactly():
    q = run(
        FR3.mjcf,
        held(*FR3.home),
        kp=100,
        kd=10,
        joints=FR3.joints,
        duration_s=0.1,
        gravity_compensation=True,
        physics_rate_hz=4000,
    )
    np.testing.assert_allclose(q[-1], FR3.home, atol=1e-7)


def test_no_motor_gives_more_than_the_mjcf_allows():
    """The FR3's wrist is allowed 12 N·m; a step of 0.2 rad at Kp 160 asks for 32."""
    home = np.array(FR3.home)
    machine = Machine(FR3.mjcf, FR3.joints, (), 4000, True, home)
    machine.demand = 160 * np.full(7, 0.2)
    machine.step()
    assert np.abs(machine.motor_torque)[:4].max() <= 87.0
    np.testing.assert_allclose(machine.motor_torque[4:], 12.0)


def test_a_delay_shifts_the_motion(pendulum):
    q, late = run(pendulum), run(pendulum, sine, fx.CommandDelay(0.012))
    np.testing.assert_allclose(late[12:], q[:-12], atol=1e-9)
    np.testing.assert_allclose(late[:12], 0, atol=1e-12)


def test_an_encoder_offset_moves_the_link_not_the_reading(pendulum):
    machine = Machine(pendulum, JOINTS, [fx.EncoderOffset(0.02)], 8000, False, np.array([0.1]))
    assert machine.q == pytest.approx(0.12)


@pytest.mark.parametrize("side", [-1, 1])
def test_backlash_leaves_half_its_width_between_encoder_and_link(pendulum, side):
    width = 0.03
    effect = fx.Backlash(width)
    machine = Machine(pendulum, JOINTS, [effect], 8000, False, np.array([0.5 * side]))
    link, rotor = (machine.model.joint(name).id for name in ("hinge", "hinge_rotor"))
    for step in range(8000):
        if step % 8 == 0:
            machine.demand = KP * (0.5 * side - machine.q) - KD * machine.dq
        machine.step()
    play = machine.data.qpos[rotor] - machine.data.qpos[link]
    assert play == pytest.approx(side * width / 2, abs=1e-3)


@pytest.mark.parametrize(
    ("effect", "expected"),
    [
        (fx.ActuatorBandwidth(10.0), 1 - np.exp(-2 * np.pi * 10.0 * 0.01)),
        (fx.TorqueRateLimit(30.0), 0.3),
        (fx.TorqueSaturation(0.4), 0.4),
    ],
)
def test_the_motor_answers_a_step_of_torque(pendulum, effect, expected):
    """After 10 ms of a demand that jumps from 0 to 1 N·m."""
    machine = Machine(pendulum, JOINTS, [effect], 8000, False, np.array([0.0]))
    machine.step()
    machine.demand = np.array([1.0])
    for _ in range(80):
        machine.step()
    assert machine.motor_torque[0] == pytest.approx(expected, abs=3e-3)


def test_a_recording_follows_the_log_format(pendulum, tmp_path):
    facts = {"control_rate_hz": 1000, "command_rate_hz": 50, "gravity_compensation": True}
    frame = record(
        pendulum,
        JOINTS,
        KP,
        KD,
        sine,
        duration_s=0.5,
        sample_rate_hz=20,
        encoder_resolution_rad=1e-3,
        encoder_noise_rad=1e-3,
        rng=np.random.default_rng(0),
        with_velocity=True,
        **facts,
    )
    write(frame, tmp_path / "a" / "swing", robot=pendulum, joints=JOINTS, kp=KP, kd=KD, **facts)

    table = pd.read_csv(tmp_path / "a" / "swing.csv")
    assert list(table) == ["time", "q_des.hinge", "q.hinge", "dq.hinge"]
    commands = table[np.isclose(table.time * 50 % 1 % 1, 0, atol=1e-6)]
    np.testing.assert_allclose(commands["q_des.hinge"], sine(commands.time.to_numpy())[:, 0])
    samples = table["q.hinge"].dropna()
    assert len(samples) == 10
    np.testing.assert_allclose(samples / 1e-3, np.round(samples / 1e-3), atol=1e-6)

    log = yaml.safe_load((tmp_path / "a" / "swing.yaml").read_text())
    assert log == {"robot": "../pendulum.xml", "joints": ["hinge"], "kp": KP, "kd": KD} | facts


def test_the_table_hides_every_effect_and_repeats_itself():
    table = cases()
    assert len({case.name for case in table}) == len(table)
    removed = [entry.case for entry in proposals.cases().values()]
    others = (*removed, *cases_on_robots(116))
    hidden = {type(effect) for case in (*table, *others) for effect in case.hidden}
    known = {
        e
        for e in (*vars(fx).values(), *vars(rx).values())
        if isinstance(e, type) and issubclass(e, fx.HiddenEffect)
    }
    assert hidden == known - {fx.HiddenEffect, fx.TwoMass, rx.Warming}

    case = next(c for c in table if c.name == "coulomb_friction_1_pendulum")
    case = dataclasses.replace(case, changes={"duration_s": 0.5})
    first, second = (recording(case, 2, case.hidden) for _ in range(2))
    pd.testing.assert_frame_equal(first, second)


def test_small_robots_touch_nothing():
    for name in ("pendulum", "two_joint_arm"):
        model = mujoco.MjModel.from_xml_path(str(ROBOTS[name].mjcf))
        assert not model.geom_contype.any()


# ------------------------------------------------------------------------ what robots really have


def at_rest(pendulum, *hidden, **settings):
    """Where a pendulum held at 0.8 rad comes to rest."""
    return run(pendulum, held(0.8), *hidden, duration_s=0.1, sample_rate_hz=50, **settings)[-1]


@pytest.mark.parametrize(
    ("hidden", "pull"),
    [
        (rx.ParallelSpring(0.7, 0.2), lambda q: -0.7 * (q - 0.2) - WEIGHT * np.sin(q)),
        (rx.BaseTilt(0.0, 0.2), lambda q: -WEIGHT * np.sin(q + 0.2)),
        (rx.IntegralAction(60.0, 0.5), lambda q: 0.5 - WEIGHT * np.sin(q)),
    ],
)
def test_at_rest_the_torques_of_an_effect_balance(pendulum, hidden, pull):
    q = at_rest(pendulum, hidden)
    assert KP * (0.8 - q) + pull(q) == pytest.approx(0, abs=2e-3)


def test_a_clock_that_is_early_shows_what_comes_later(pendulum):
    early = run(pendulum, sine, rx.ClockOffset(0.02), duration_s=0.3)
    np.testing.assert_allclose(early[:-20], run(pendulum, sine, duration_s=0.3)[20:], atol=1e-12)


def test_a_session_is_logged_where_an_effect_needs_it(pendulum):
    hidden = (rx.TorqueSpeedLimit(5.0, 20.0, 12.0, 0.5), rx.FrictionDrift(0.1, 0.0, 5.0))
    frame = record(
        pendulum, JOINTS, KP, KD, sine, duration_s=0.1, hidden=hidden, session_time_s=4.0
    )
    np.testing.assert_allclose(frame["time"].iloc[0], 4.0)
    np.testing.assert_allclose(frame["supply_voltage"].iloc[0], 10.0)


def test_a_late_log_with_the_motor_off_tells_what_the_pendulum_did(pendulum):
    """What the log says at its own times, put into the equation, gives the motion that it has."""
    log = record(
        pendulum, JOINTS, KP, KD, sine, duration_s=1.5, sample_rate_hz=200,
        off_s=[(0.5, 1.0)], logger=Logger(lateness_s=1e-3), rng=np.random.default_rng(3),
    )  # fmt: skip
    assert np.diff(log["time"]).std() > 5e-4
    assert (log["torque_enabled"] == 0).mean() == pytest.approx(1 / 3, abs=0.01)
    state, expected = np.zeros(2), np.full(len(log), np.nan)
    for tick in range(1500):
        row = np.searchsorted(log["time"], tick / 1000 + 1e-9, side="right") - 1
        torque = KP * (log["q_des.hinge"][row] - state[0]) - KD * state[1]
        torque *= log["torque_enabled"][row]

        def motion(_, x, torque=torque):
            return x[1], (torque - WEIGHT * np.sin(x[0]) - DAMPING * x[1]) / INERTIA

        inside = (log["time"] >= tick / 1000 - 1e-9) & (log["time"] < (tick + 1) / 1000 - 1e-9)
        at = np.clip(log["time"][inside] - tick / 1000, 0, None).tolist()
        y = solve_ivp(motion, (0, 1e-3), state, t_eval=[*at, 1e-3], rtol=1e-9, atol=1e-12).y
        expected[np.flatnonzero(inside)], state = y[0, :-1], y[:, -1]
    np.testing.assert_allclose(log["q.hinge"], expected, atol=1e-7)


def test_a_logger_loses_and_repeats_rows_of_the_same_motion(pendulum):
    def log(**logger):
        rng = np.random.default_rng(0)
        settings = {
            "duration_s": 2.0,
            "sample_rate_hz": 200,
            "rng": rng,
            "logger": Logger(**logger),
        }
        return record(pendulum, JOINTS, KP, KD, sine, **settings)

    whole, less = log(lateness_s=1e-4), log(lateness_s=1e-4, lost=0.1, repeated=0.1)
    commands = whole["q_des.hinge"].diff() != 0
    assert less["time"].iloc[0] == 0
    assert 0.8 * len(whole) < less["time"].nunique() < 0.97 * len(whole)
    assert 0.02 * len(whole) < less["time"].duplicated().sum() < 0.2 * len(whole)
    among = whole[whole["time"].isin(less["time"])].reset_index(drop=True)
    pd.testing.assert_frame_equal(less.drop_duplicates(ignore_index=True), among)
    kept = whole["time"].isin(less["time"])
    assert kept[commands].all()
    blurred = log(lateness_s=1e-4, stamp_error_s=1e-3)
    assert (blurred["time"] - whole["time"]).std() == pytest.approx(1e-3, rel=0.3)
    assert (blurred["time"].diff().dropna() >= 0).all()
    np.testing.assert_array_equal(blurred["q.hinge"], whole["q.hinge"])


def test_the_motors_current_holds_the_weight(pendulum):
    log = record(pendulum, JOINTS, KP, KD, held(0.8), duration_s=0.5, torque_per_ampere=0.3)
    weight = WEIGHT * np.sin(log["q.hinge"])
    np.testing.assert_allclose(0.3 * log["current.hinge"], weight, atol=0.3 * 0.03)
    assert 0.3 * log["current.hinge"].mean() == pytest.approx(weight.mean(), abs=2e-3)


def test_some_drawn_logs_begin_in_motion_are_late_or_lack_rows():
    setups = [case.setup for case in cases(5)]
    for trait in ("lateness_s", "lost", "repeated"):
        assert 0.1 < np.mean([getattr(setup.logger, trait) > 0 for setup in setups]) < 0.5
    assert 0.1 < np.mean([setup.begin_s > 0 for setup in setups]) < 0.5


def test_a_seed_draws_one_test_set_and_no_other():
    one, again, other = (cases(seed) for seed in (5, 5, 6))
    assert one == again
    same = [a.hidden == b.hidden for a, b in zip(one, other, strict=True) if a.hidden]
    assert np.mean(same) < 0.05  # a rate of the loop may be drawn twice
    assert not {c.name for c in one} & {c.name for c in cases()}


def test_what_is_removed_from_the_library_is_in_it_and_a_right_answer_is_judged_right():
    known = builtin()
    for name, removed in proposals.cases().items():
        assert set(removed.without) <= set(known), name
        assert set(removed.joints) <= set(ROBOTS[removed.case.robot].joints), name
    for name, removed in proposals.mixed().items():
        assert len(removed.case.hidden) == 2, name
        assert set(removed.besides) <= set(known) - set(removed.without), name
    result = {"case": "mixed_spring_pendulum", "adopted": ["coulomb_friction", "cogging"]}
    assert proposals.wrong_names(result) == ["cogging"]
    spring = {"joint": "hinge", "of": "hinge", "follows": "position"}
    friction = spring | {"follows": "constant"}
    for curves, is_right in (([spring, friction], True), ([friction], False), ([spring], True)):
        assert proposals.right(result | {"curves": curves}) is is_right
    assert proposals.right(result | {"curves": [spring, spring | {"follows": "time"}]}) is False
    law = {"joint": "elbow", "of": "elbow", "follows": "position"}
    spring = {"case": "spring_two_joint_arm", "after": 1.9e-4, "noise_floor": 1e-4}
    assert proposals.right(spring | {"curves": [law]}) is True
    for wrong in ({"of": "shoulder"}, {"joint": "shoulder"}, {"follows": "time"}):
        assert proposals.right(spring | {"curves": [law, law | wrong]}) is False
    assert proposals.right(spring | {"curves": []}) is False
    curve, far = spring | {"curves": [law], "in_words": None}, {"after": 2.1e-4}
    assert proposals.near(curve) is True
    assert proposals.near(curve | far) is False
    for left, near in ((1.9e-4, True), (2.1e-4, False)):
        formula = curve | {"in_words": left}
        assert proposals.near(formula) is proposals.near(formula | far) is near
    loop = {"case": "integral_pendulum", "curves": [law], "after": 1.0, "noise_floor": 1e-4}
    assert proposals.right(loop) is proposals.near(loop) is None


# --------------------------------------------------------------------------------- more robots


@pytest.mark.parametrize("name", NAMES)
def test_a_heavier_robot_under_gains_as_much_higher_moves_the_same(name):
    robot = ROBOTS[name]
    (gains,) = robot.setup.gains
    amplitude, factor = np.array(robot.amplitude), 50.0

    def move(t):
        return np.array(robot.home) + amplitude * np.sin(6 * t[:, None])

    light, heavy = (
        run(
            scaled(robot.mjcf.read_text(), times), move,
            kp=times * np.array(gains[0]), kd=times * np.array(gains[1]),
            joints=robot.joints, duration_s=0.2, gravity_compensation=True,
        )
        for times in (1.0, factor)
    )  # fmt: skip
    assert np.abs(light - light[0]).max() > 0.01
    np.testing.assert_allclose(heavy, light, atol=1e-5)


def test_a_slide_falls_under_a_payload_it_does_not_know():
    scara = ROBOTS["scara"]
    home, mass, kp = np.array(scara.home), 0.5, np.array([300.0, 60.0, 1500.0, 4.0])
    q = run(
        scara.mjcf, held(*home), fx.Payload(mass), kp=kp, kd=scara.setup.gains[0][1],
        joints=scara.joints, duration_s=0.1, gravity_compensation=True,
    )[-1]  # fmt: skip
    np.testing.assert_allclose(home - q, [0, 0, mass * GRAVITY / kp[2], 0], atol=1e-5)


def test_a_loop_settles_where_a_simulated_one_does(pendulum):
    """A mass under damping alone, held for a period T, comes to rest while Kd T / M < 2."""
    mass, kp = np.array([[2.0]]), np.array([1e-3])
    assert settles(mass, kp, np.array([0.99 * 2 * 2.0 * 100]), 0.01)
    assert not settles(mass, kp, np.array([1.01 * 2 * 2.0 * 100]), 0.01)


def test_a_seed_draws_cases_on_every_robot():
    one, again, other = (cases_on_robots(seed) for seed in (5, 5, 6))
    assert one == again
    assert not {c.name for c in one} & {c.name for c in other}
    assert {c.robot for c in one} == set(NAMES)
    assert {len(c.hidden) for c in one} == set(range(6))
    factors = [c.mass_factor for c in one]
    assert max(factors) / min(factors) > 100
    for case in one:
        case.truth()
        told = case.setup
        assert 3 <= len(case.train) <= 6
        assert len(case.holdout) == 2
        assert {gain for _, gain, *_ in case.train} == set(range(len(told.gains)))
        rates = (told.control_rate_hz, told.command_rate_hz, told.sample_rate_hz)
        assert all(told.physics_rate_hz % rate == 0 for rate in rates)


def test_a_drawn_robot_is_written_with_its_masses(tmp_path):
    case = next(c for c in cases_on_robots(5) if c.robot == "light_arm" and not c.hidden)
    case = dataclasses.replace(
        case, changes=case.changes | {"duration_s": 0.2}, train=case.train[:1]
    )
    make(case, tmp_path / "case")
    assert is_complete(case, tmp_path / "case")
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "case/light_arm.xml"))
    assert model.body_mass.sum() == pytest.approx(0.007 * case.mass_factor, rel=1e-4)
    assert len(list((tmp_path / "case").glob("*/*.csv"))) == 3
