"""Fits of `diagnosis` and `rival` as a user of mujoco.sysid would write them."""

import io
import logging
from collections.abc import Sequence

import mujoco
import numpy as np
from mujoco import sysid

from t2l.recordings.recording import Recording
from t2l.robots import plant

TIMESTEP_S = 0.001
MAX_ITERATIONS = 200

# it warns of every recording that its columns are states, not sensors
logging.getLogger("absl").setLevel(logging.ERROR)

# attribute of the joint: the largest value that the fit may give it
UPPER = {"frictionloss": 5.0, "damping": 5.0, "armature": 1.0}


def fit(
    recordings: Sequence[Recording], start: dict[str, float], own_residual: bool
) -> sysid.ParameterDict:
    """Fit attributes of every joint; nominal values are the MJCF's.

    Args:
        start: for each attribute what to start with on every joint, beyond the MJCF's.
        own_residual: minimise what mujoco.sysid does by default, each joint's error over the size
            of its signal, instead of the error in rad.
    """
    groups = [_sequences(recording) for recording in recordings]
    residual = {} if own_residual else {"modify_residual": in_rad}
    best, _ = sysid.optimize(
        _parameters(groups[0].spec, recordings[0].joints, start),
        sysid.build_residual_fn(models_sequences=groups, **residual),
        optimizer="mujoco",
        verbose=False,
        max_iters=MAX_ITERATIONS,
        output=io.StringIO(),
    )
    return best


def rmse(recordings: Sequence[Recording], parameters: sysid.ParameterDict) -> float:
    """Of the positions that the fitted model predicts, rad."""
    groups = [_sequences(recording) for recording in recordings]
    predict = sysid.build_residual_fn(models_sequences=groups, modify_residual=in_rad)
    residuals, _, _ = predict(parameters.as_vector(), parameters.copy())
    return float(np.sqrt(np.mean(np.concatenate(residuals) ** 2)))


def in_rad(params, predicted, measured, model, return_pred_all, state=None, sensor_weights=None):
    """Error of the positions in rad, a `ModifyResidualFn`."""
    seen = measured.times >= state[0, 0]
    times, q = measured.times[seen], measured.data[seen]
    found = [np.interp(times, state[:, 0], column) for column in state[:, 1 : 1 + model.nq].T]
    return (
        q - np.column_stack(found),
        sysid.TimeSeries(times, np.column_stack(found)),
        sysid.TimeSeries(times, q),
    )


def _sequences(recording: Recording) -> sysid.ModelSequences:
    """A recording with the robot that has its gains as position actuators."""
    spec = plant.load(recording.robot, recording.joints)
    spec.option.timestep = TIMESTEP_S
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    for body in spec.bodies:
        if body.name != "world":
            body.gravcomp = float(bool(recording.gravity_compensation))
    for joint, kp, kd in zip(recording.joints, recording.kp, recording.kd, strict=True):
        actuator = spec.add_actuator(name=joint, target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        actuator.set_to_position(kp=kp, kv=kd)
    model = spec.compile()
    measured = ~np.isnan(recording.q).all(axis=1)
    q = recording.q[measured]
    # a step beyond the last measurement: what is simulated ends one before the last command
    times = TIMESTEP_S * np.arange(round(recording.duration_s / TIMESTEP_S) + 2)
    row = np.searchsorted(recording.time, times + 1e-9, side="right") - 1
    # the state, since the sensors that a rollout records lag it by a step
    positions = [(joint, sysid.SignalType.MjStateQPos) for joint in recording.joints]
    return sysid.ModelSequences(
        recording.name,
        spec,
        recording.name,
        sysid.create_initial_state(model, q[0]),
        sysid.TimeSeries(times, recording.q_des[row]),
        sysid.TimeSeries.from_names(recording.time[measured], q, model, positions),
        allow_missing_sensors=True,
    )


def _parameters(
    spec: mujoco.MjSpec, joints: Sequence[str], start: dict[str, float]
) -> sysid.ParameterDict:
    parameters = sysid.ParameterDict()
    for attribute, added in start.items():
        for joint in joints:

            def write(spec, parameter, joint=joint, attribute=attribute):
                value = parameter.value[0]
                if attribute == "damping":  # a polynomial
                    spec.joint(joint).damping[0] = value
                else:
                    setattr(spec.joint(joint), attribute, value)

            nominal = np.ravel(getattr(spec.joint(joint), attribute))[0]
            parameter = sysid.Parameter(
                f"{attribute} {joint}", nominal, 0.0, UPPER[attribute], modifier=write
            )
            parameter.value[:] = nominal + added
            parameters.add(parameter)
    return parameters
