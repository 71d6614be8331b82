"""Motors under a voltage, against their equation."""

import dataclasses

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from t2l.detective.data_split import split
from t2l.detective.search import search
from t2l.identify.drive_torque import drive_torque
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor
from t2l.identify.scales import scales
from t2l.recordings.motor import Motor
from t2l.recordings.recording import held
from tests.conftest import ROOT
from tests.diagnose.made import ARMATURE, INERTIA, WEIGHT, pendulum, predict, recording, swing

KT, RESISTANCE, SUPPLY_V = 1.0, 5.0, 8.0
MOTOR = Motor(*(np.array([x]) for x in (KT, RESISTANCE, SUPPLY_V)))
XL330 = ROOT.parent / "shared/data/xl330_pendulum"
RATE_HZ = 200.0  # of rows
LOOP_HZ = 1000.0
CLOSE_RAD = 3e-4


def moved(
    duty, seconds=2.0, rate_hz=RATE_HZ, volts=lambda t: SUPPLY_V, on=lambda t: True, friction=0.0
):
    """Position (n,) at the rows under duty(t, q, dq), which is held and cut, and the duties."""
    state, q, told = (0.2, 0.0), [], []
    every = round(LOOP_HZ / rate_hz)
    for tick in range(every * round(seconds * rate_hz) + 1):
        t = tick / LOOP_HZ
        q.append(state[0])
        told.append(np.clip(duty(t, *state), -1, 1))

        given, runs = told[-1] * volts(t), on(t)

        def motion(_, x, given=given, runs=runs):
            motor = KT / RESISTANCE * (given - KT * x[1]) * runs
            rubs = friction * np.tanh(x[1] / 2e-3)
            return x[1], (motor - rubs - WEIGHT * np.sin(x[0])) / INERTIA

        end = solve_ivp(motion, (0, 1 / LOOP_HZ), state, "LSODA", rtol=1e-8, atol=1e-10)
        state = tuple(end.y[:, -1])
    return np.array(q)[::every], np.array(told)[::every]


def led(hz, gain=12.0):
    """The law of a servo: duty by the error alone; commands come with the rows."""
    way = swing(0.5, hz)
    return lambda t, q, dq: gain * (way(np.floor(t * RATE_HZ + 1e-6) / RATE_HZ) - q)


def log(
    robot,
    hz=0.9,
    gain=12.0,
    seconds=2.0,
    noise=0.0,
    seed=0,
    motor=MOTOR,
    volts=None,
    on=None,
    **machine,
):
    """A recording of such a servo, whose loop runs at the rate of the rows."""
    given = {} if volts is None else {"volts": volts}
    given |= {} if on is None else {"on": on}
    q, _ = moved(led(hz, gain), seconds, **given, **machine)
    made = recording(
        robot, swing(0.5, hz), f"servo{hz:g}", gain * MOTOR.stall[0], 0.0, seconds, motor=motor,
        row_rate_hz=RATE_HZ, control_rate_hz=LOOP_HZ,
    )  # fmt: skip
    noisy = q + noise * np.random.default_rng(seed).normal(size=len(q))
    # a log that begins by falling: its velocity at the first row is known
    changes = {"q": noisy[:, None], "dq": np.where(made.time == 0, 0.0, np.nan)[:, None]}
    if volts is not None:
        changes["supply_voltage"] = np.array([[volts(t)] for t in made.time])
    if on is not None:
        changes["torque_enabled"] = np.array([[float(on(t))] for t in made.time])
    return dataclasses.replace(made, **changes)


def worst(made):
    return np.abs(predict(made) - made.q[:, 0]).max()


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    # all damping is the motor's
    return pendulum(tmp_path_factory.mktemp("robot"), f'armature="{ARMATURE}"')


def test_back_emf_damps(robot):
    made = log(robot)
    assert worst(made) < CLOSE_RAD
    # as a Kd of the loop it would be sampled; without it nothing damps
    assert worst(dataclasses.replace(made, motor=None)) > 100 * CLOSE_RAD


def test_duty_is_cut(robot):
    made = log(robot, gain=60.0)
    assert (np.abs(60.0 * (made.q_des - made.q)) > 1).mean() > 0.2
    assert worst(made) < 2 * CLOSE_RAD


def test_the_torque_follows_a_logged_supply(robot):
    def volts(t):
        row = np.floor(t * RATE_HZ + 1e-6) / RATE_HZ  # as the log has it
        return SUPPLY_V * (1.1 - 0.2 * row)

    logged = dataclasses.replace(MOTOR, logged=True)
    made = log(robot, gain=30.0, volts=volts, motor=logged)
    assert worst(made) < 2 * CLOSE_RAD
    assert worst(dataclasses.replace(made, motor=MOTOR)) > 10 * CLOSE_RAD


def test_a_motor_that_is_off_does_not_brake(robot):
    made = log(robot, seconds=3.0, on=lambda t: t < 1.5)
    assert worst(made) < 2 * CLOSE_RAD


def test_a_log_of_duties_is_held_softly(robot):
    way, gain = swing(0.5, 0.9), 12.0
    q, told = moved(lambda t, q, dq: gain * (way(t) - q), 3.0, LOOP_HZ)
    made = recording(
        robot, lambda t: 0 * t, "duties", 0.0, 0.0, 3.0, motor=MOTOR, control="duty",
        row_rate_hz=LOOP_HZ,
    )  # fmt: skip
    column = q[:, None]
    made = dataclasses.replace(
        made,
        q=column,
        q_des=held(column),
        tau_ff=told[:, None] * MOTOR.stall,
        dq=np.where(made.time == 0, 0.0, np.nan)[:, None],
    )
    assert worst(made) < CLOSE_RAD


def test_what_remains_is_friction(robot):
    motions = ((0.7, 8.0), (0.9, 12.0), (1.1, 20.0), (0.8, 12.0))
    logs = [
        log(robot, hz, gain, noise=3e-4, seed=seed, friction=0.05)
        for seed, (hz, gain) in enumerate(motions)
    ]
    found = search(Model(robot), split(robot, logs, threads=1)).model.effects
    assert set(found) == {"coulomb_friction"}
    assert found["coulomb_friction"]["torque"]["hinge"] == pytest.approx(0.05, abs=0.003)


def test_no_torque_beyond_full_duty_is_taken_for_a_size(robot):
    made = log(robot, gain=60.0)
    fastest = np.abs(np.gradient(made.q[:, 0], made.time)).max()
    most = scales(Predictor(robot, [made], threads=1)).peak_torque[0]
    # and back-EMF of a joint that is turned the other way
    assert most < 1.1 * (MOTOR.stall[0] + MOTOR.back_emf[0] * fastest)
    assert most < 0.7 * np.abs(made.kp * (made.q_des - made.q)).max()


@pytest.mark.skipif(not XL330.is_dir(), reason=f"the recordings of {XL330} are not here")
@pytest.mark.parametrize("gain", [100, 200, 800])
def test_a_real_servo_gives_the_duty_of_its_register(robot, gain):
    table = np.genfromtxt(XL330 / f"kp{gain}_up_and_down.csv", delimiter=",", names=True)
    # DYNAMIXEL X: counts of a turn, and what BAM measured the divisor to be
    per_rad = 4096 / (2 * np.pi) / (256 * 885) * gain
    made = recording(
        robot, lambda t: 0 * t, "servo", per_rad * MOTOR.stall[0], 0.0, 1.0, motor=MOTOR
    )
    made = dataclasses.replace(
        made, time=table["time_s"], q_des=table["goal_position_rad"][:, None],
        q=table["position_rad"][:, None],
    )  # fmt: skip
    predictor = Predictor(robot, [made], threads=1)
    zero = np.zeros(len(made.time))
    given = drive_torque(predictor, made.q[:, 0], zero, zero) / MOTOR.stall
    register = np.where(table["duty"] > 32767, table["duty"] - 65536, table["duty"])
    assert np.sqrt(np.mean((given - register / 885) ** 2)) < 0.02
    if gain == 800:
        assert (np.abs(given) == 1).mean() > 0.2
