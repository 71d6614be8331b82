"""Drives that take a velocity and a torque beside the position, and joints without a drive."""

import dataclasses

import mujoco
import numpy as np
import pytest

from t2l.effects.registry import builtin
from t2l.effects.term import Layout, Term
from t2l.identify.prediction import Predictor, Request
from t2l.recordings import Recording, read_recording, write_recording
from t2l.sim.driven_loop import DrivenLoop, Path
from tests.diagnose.made import predict

JOINTS = ("shoulder", "elbow")
HOME = np.array([0.4, -0.6])
ARM = """
<mujoco>
  <option timestep="0.0005" integrator="RK4"/>
  <compiler angle="radian"/>
  <worldbody>
    <body>
      <joint name="shoulder" axis="0 1 0" damping="0.05" armature="0.02"/>
      <geom type="capsule" fromto="0 0 0 0 0 -0.3" size="0.02" mass="1"/>
      <body pos="0 0 -0.3">
        <joint name="elbow" axis="0 1 0" damping="0.02" armature="0.01"/>
        <geom type="capsule" fromto="0 0 0 0 0 -0.25" size="0.02" mass="0.6"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""
PERIOD_S, STEPS, ROWS_PER_S = 0.002, 4, 100


def wanted(t):
    """Position and velocity along a motion, (n, 2) rad and rad/s."""
    rates, sizes = 2 * np.pi * np.array([0.9, 1.4]), np.array([0.5, 0.7])
    phase = np.outer(t, rates)
    return HOME + sizes * (1 - np.cos(phase)), sizes * rates * np.sin(phase)


def recorded(folder, kp, kd, late_s=0.0, duration_s=2.0):
    """The arm under the law that drives state, by a plain loop over MuJoCo.

    Args:
        late_s: how late all three commands arrive.
    """
    path = folder / "arm.xml"
    path.write_text(ARM)
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    data.qpos[:] = HOME
    kp, kd = np.array(kp, float), np.array(kd, float)
    time = np.arange(round(duration_s * ROWS_PER_S)) / ROWS_PER_S
    q_des, dq_des = wanted(time)
    tau_ff = np.stack([0.8 * np.sin(9 * time), 0.5 * np.cos(7 * time) - 0.5], axis=1)
    q = np.empty_like(q_des)
    per_row = round(1 / ROWS_PER_S / PERIOD_S)
    late = round(late_s / PERIOD_S)
    for tick in range(len(time) * per_row):
        row = max(tick - late, 0) // per_row
        if tick % per_row == 0:
            q[tick // per_row] = data.qpos
        error, rate = q_des[row] - data.qpos, dq_des[row] - data.qvel
        data.qfrc_applied[:] = kp * error + kd * rate + tau_ff[row]
        mujoco.mj_step(model, data, nstep=STEPS)
    return Recording(
        name="led", path=None, robot=str(path), joints=JOINTS, kp=kp, kd=kd,
        command_rate_hz=ROWS_PER_S, control_rate_hz=1 / PERIOD_S, gravity_compensation=False,
        time=time, q_des=q_des, dq_des=dq_des, tau_ff=tau_ff, q=q,
        dq=np.where(np.arange(len(time))[:, None] == 0, 0.0, np.nan) + 0 * q,
    )  # fmt: skip


def rms(recording, *terms):
    """Of the error of a model with effects (name, values), rad."""
    layout = Layout([Term(builtin()[name], (0, 1)) for name, _ in terms])
    u = layout.encode({name: values for name, values in terms})
    predictor = Predictor(recording.robot, [recording], substeps=4)
    (q,) = predictor.predict([Request(layout, u[None])])
    return float(np.sqrt(np.mean((q[0] - recording.q.ravel()) ** 2)))


def test_commanded_velocity_and_torque_are_followed(tmp_path):
    assert rms(recorded(tmp_path, [20, 12], [1.0, 0.6])) < 5e-5


def test_coarse_ticks_take_their_means(tmp_path):
    made = recorded(tmp_path, [20, 12], [1.0, 0.6])
    coarse = Predictor(made.robot, [made], substeps=4, coarseness=2)
    (q,) = coarse.predict([Request(Layout(()), np.zeros((1, 0)))])
    assert np.sqrt(np.mean((q[0] - made.q.ravel()) ** 2)) < 1e-4


@pytest.mark.parametrize("column", ["dq_des", "tau_ff"])
def test_without_either_the_model_goes_elsewhere(tmp_path, column):
    made = recorded(tmp_path, [20, 12], [1.0, 0.6])
    assert rms(dataclasses.replace(made, **{column: None})) > 100 * rms(made)


def test_they_are_what_is_folded_into_the_position_command(tmp_path):
    made = recorded(tmp_path, [20, 12], [1.0, 0.6])
    folded = dataclasses.replace(
        made, q_des=made.q_des + made.feed_forward / made.kp, dq_des=None, tau_ff=None
    )
    np.testing.assert_allclose(predict(made), predict(folded), atol=1e-9)


def test_they_are_kept_in_a_file_and_beside_recordings_without(tmp_path):
    made = recorded(tmp_path, [20, 12], [1.0, 0.6])
    back = read_recording(write_recording(made, tmp_path / "led"))
    np.testing.assert_array_equal(back.dq_des, made.dq_des)
    np.testing.assert_array_equal(back.tau_ff, made.tau_ff)
    bare = dataclasses.replace(made, name="bare", dq_des=None, tau_ff=None)
    both = Predictor(made.robot, [back, bare])
    (q,) = both.predict([Request(Layout(()), np.zeros((1, 0)))])
    np.testing.assert_allclose(q[0], np.concatenate([predict(back), predict(bare)]), atol=1e-12)


def test_a_delay_delays_all_three(tmp_path):
    made = recorded(tmp_path, [20, 12], [1.0, 0.6], late_s=0.02)
    late = rms(made, ("command_delay", {"delay": np.array([0.02])}))
    assert late < 1e-4
    assert rms(made) > 50 * late


@pytest.mark.parametrize(
    ("effect", "values"),
    [
        ("command_filter", {"cutoff": np.array([4.0])}),
        ("command_delay", {"delay": np.array([0.013])}),
        ("controller_gains", {"kp_factor": np.full(2, 1.1), "kd_factor": np.full(2, 1.1)}),
        ("torque_constant", {"factor": np.full(2, 0.9)}),
        ("clock_offset", {"offset": np.array([-0.013])}),
    ],
)
def test_effects_act_on_them_as_on_what_is_folded(tmp_path, effect, values):
    made = recorded(tmp_path, [20, 12], [1.0, 0.6])
    if effect == "controller_gains":
        made = dataclasses.replace(made, tau_ff=None)  # no gain is applied to it
    folded = dataclasses.replace(
        made, q_des=made.q_des + made.feed_forward / made.kp, dq_des=None, tau_ff=None
    )
    layout = Layout([Term(builtin()[effect], (0, 1))])
    u = layout.encode({effect: values})[None]
    found = [Predictor(r.robot, [r]).predict([Request(layout, u)])[0][0] for r in (made, folded)]
    np.testing.assert_allclose(*found, atol=1e-9)


def test_a_loop_that_is_led_gives_the_same_torque(tmp_path):
    made = recorded(tmp_path, [20, 12], [1.0, 0.6])
    predictor = Predictor(made.robot, [made])
    ((group, q, dq),) = predictor.at_ticks(Layout(()), np.zeros(0))
    zero = np.zeros_like(q)
    loop = DrivenLoop(predictor.model(), JOINTS, group.schedule, 1)
    torque = loop.torque(Path(q, dq, zero, zero, zero, np.full(2, 1e-3)))[:, 0]
    row = np.minimum(np.arange(len(q)) * PERIOD_S * ROWS_PER_S + 1e-6, len(made.time) - 1)
    row = row.astype(int)
    stated = made.kp * (made.q_des[row] - q[:, 0]) + made.kd * (made.dq_des[row] - dq[:, 0])
    np.testing.assert_allclose(torque[:, 0], stated + made.tau_ff[row], atol=1e-9)


@pytest.mark.parametrize("kd", [[1.0, 0.6], [1.0, 0.0]])
def test_a_joint_without_stiffness_is_predicted(tmp_path, kd):
    made = recorded(tmp_path, [20, 0], kd)
    back = read_recording(write_recording(made, tmp_path / "led"))
    assert back.cell == "led"
    # it is free to swing through several turns of a chaotic arm
    assert rms(back) < 5e-4 * np.ptp(back.q)
    assert rms(dataclasses.replace(back, tau_ff=None)) > 100 * rms(back)
