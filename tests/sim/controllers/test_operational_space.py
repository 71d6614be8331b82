import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from t2l.robots import make_robot
from t2l.sim import make_batch
from t2l.sim.controllers.arm_dynamics import ArmDynamics
from t2l.sim.controllers.operational_space import (
    DAMPING,
    LARGEST_TURN,
    POSE_SIZE,
    POSTURE_STIFFNESS,
    OperationalSpacePD,
    operational_space_torque,
    rotation_error,
)

SEEDS = st.integers(0, 10_000)
KPS, KDS = st.floats(1, 5000), st.floats(0.1, 500)


@given(seed=st.integers(0, 10_000))
def test_the_grip_accelerates_as_asked_and_the_posture_does_not_disturb_it(seed):
    rng = np.random.default_rng(seed)
    factor = rng.normal(size=(7, 7))
    mass = (factor @ factor.T + 3 * np.eye(7))[None]
    jacobian = rng.normal(size=(1, 6, 7))
    q, dq, bias = rng.normal(size=(3, 1, 7))
    error, twist_des, acceleration_des = rng.normal(size=(3, 1, 6))
    torque = operational_space_torque(
        *(q, dq, mass, jacobian, bias, error),
        *(twist_des, acceleration_des, rng.normal(size=7), 100.0, 20.0),
    )
    acceleration = jacobian[0] @ np.linalg.solve(mass[0], (torque - bias)[0])
    asked = acceleration_des + 100 * error + 20 * (twist_des - (jacobian @ dq[0])[..., :])
    condition = np.linalg.cond(jacobian[0] @ np.linalg.solve(mass[0], jacobian[0].T))
    # damped least squares gives up accuracy near singular poses
    if condition < 100:
        np.testing.assert_allclose(acceleration, asked[0], rtol=0.05, atol=0.05 * abs(asked).max())


@given(seed=SEEDS)
def test_the_torque_is_that_of_the_textbook(seed):
    """Khatib's law with every inverse written out, and the null space as a projection."""
    rng = np.random.default_rng(seed)
    factor, jacobian = rng.normal(size=(7, 7)), rng.normal(size=(6, 7))
    mass = factor @ factor.T + 3 * np.eye(7)
    q, dq, bias, posture = rng.normal(size=(4, 7))
    error, twist_des, acceleration_des = rng.normal(size=(3, 6))
    state = (part[None] for part in (q, dq, mass, jacobian, bias, error))
    torque = operational_space_torque(*state, twist_des, acceleration_des, posture, 100.0, 20.0)

    inverse = np.linalg.inv(mass)
    inertia = np.linalg.inv(jacobian @ inverse @ jacobian.T + DAMPING * np.eye(6))
    force = inertia @ (acceleration_des + 100 * error + 20 * (twist_des - jacobian @ dq))
    null_space = np.eye(7) - jacobian.T @ inertia @ jacobian @ inverse
    drift = POSTURE_STIFFNESS * (posture - q) - 2 * np.sqrt(POSTURE_STIFFNESS) * dq
    expected = jacobian.T @ force + null_space @ mass @ drift + bias
    np.testing.assert_allclose(torque[0], expected, rtol=0, atol=1e-10 * abs(expected).max())


def test_rotation_error_is_the_small_turn_between_two_frames():
    turn = np.array([0.01, -0.02, 0.015])
    frame = Rotation.from_rotvec([0.3, 1.0, -0.4])
    turned = Rotation.from_rotvec(turn) * frame
    error = rotation_error(turned.as_matrix()[None], frame.as_matrix()[None])[0]
    np.testing.assert_allclose(error, turn, rtol=1e-3)


@pytest.fixture(scope="module", params=["fr3_hand", "ur5e_2f85", "fr3_duo"])
def robot(request):
    return make_robot(request.param)


@pytest.fixture(scope="module")
def model(robot):
    return robot.spec().compile()


class Law:
    """The controller in random states, of which the first is stretched out: singular."""

    def __init__(self, robot, model, kp, kd, rng, speed, rotation=None):
        n = 8
        self.controller = OperationalSpacePD(model, robot.arms, kp, kd, rotation)
        self.batch = make_batch(model, n)
        self.controller.install(self.batch)
        low, high = robot.position_limit.T
        self.batch.qpos[:, self.controller.qpos] = rng.uniform(low, high, (n, len(low)))
        self.batch.qpos[0, self.controller.qpos] = 0
        self.batch.qvel[:, self.controller.dofs] = speed * rng.normal(size=(n, len(low)))
        self.arms = [ArmDynamics(self.batch, arm) for arm in robot.arms]
        self.state = self.batch.qpos.copy(), self.batch.qvel[:, self.controller.dofs].copy()
        self.pose = self.controller.measured(self.batch)
        self.mass = [arm.mass() for arm in self.arms]
        self.jacobian = [arm.jacobian() for arm in self.arms]
        mobility = [
            j @ np.linalg.solve(m, j.transpose(0, 2, 1))
            for j, m in zip(self.jacobian, self.mass, strict=True)
        ]
        smallest = np.linalg.eigvalsh(np.stack(mobility))[..., 0].min(axis=0)
        # relative, (n, 1); near a singular pose it grows as 1/√smallest, which is cut at 1e-14
        self.rounding = np.where(smallest > 0.01, 1e-12, 1e-6)[:, None]
        self.bias = np.concatenate([arm.bias() for arm in self.arms], axis=1)

    def torque(self, command):
        """(n, njoint) N·m that it commands."""
        batch, start = self.batch, self.batch.state.copy()
        self.controller.step(batch, command, np.ones(len(command), dtype=bool), 1)
        torque = batch.ctrl[:, self.controller.ctrl].copy()
        batch.state[:] = start
        batch.forward()
        return torque

    def command(self, torque):
        return self.controller.solved(*self.state, torque)

    def acceleration(self, torque):
        """(n, narm, 6) of the tools by torques (n, njoint), m/s² and rad/s²."""
        net = np.split(torque - self.bias, len(self.arms), axis=1)
        parts = zip(self.jacobian, self.mass, net, strict=True)
        return np.stack([(j @ np.linalg.solve(m, t[:, :, None]))[..., 0] for j, m, t in parts], 1)

    def turned(self, command):
        """(n, narm, 3) rad, rotation vectors from the tools' orientations to a command's."""
        there, here = (p.reshape(-1, POSE_SIZE)[:, 3:] for p in (command, self.pose))
        between = there.reshape(-1, 3, 3) @ here.reshape(-1, 3, 3).transpose(0, 2, 1)
        return Rotation.from_matrix(between).as_rotvec().reshape(len(command), -1, 3)


@given(seed=SEEDS, kp=KPS, kd=KDS, factor=st.none() | st.floats(0.1, 10))
def test_solved_is_the_exact_inverse_of_the_law(robot, model, seed, kp, kd, factor):
    rng = np.random.default_rng(seed)
    rotation = factor and {"kp": factor, "kd": np.sqrt(factor)}
    law = Law(robot, model, kp, kd, rng, speed=1.0, rotation=rotation)
    pose = law.pose.reshape(-1, POSE_SIZE)
    axis = rng.normal(size=(len(pose), 3))
    angle = rng.uniform(0, LARGEST_TURN, (len(pose), 1))
    turn = Rotation.from_rotvec(angle * axis / np.linalg.norm(axis, axis=1, keepdims=True))
    there = (turn * Rotation.from_matrix(pose[:, 3:].reshape(-1, 3, 3))).as_matrix()
    position = pose[:, :3] + rng.normal(size=(len(pose), 3))
    command = np.concatenate([position, there.reshape(-1, 9)], axis=1).reshape(law.pose.shape)
    torque = law.torque(command)
    again = law.torque(law.command(torque))
    assert (abs(again - torque) < law.rounding * abs(torque).max()).all()


@given(seed=SEEDS, kp=KPS, kd=KDS)
def test_a_solved_command_moves_the_tool_as_any_torque_does(robot, model, seed, kp, kd):
    rng = np.random.default_rng(seed)
    law = Law(robot, model, kp, kd, rng, speed=0.2 * min(1, kp / kd))
    torque = law.bias + min(5, 0.01 * kp) * rng.normal(size=law.bias.shape)
    command = law.command(torque)
    # close to a singular pose, some take more than half a turn
    possible = np.linalg.norm(law.turned(command), axis=2).max(axis=1) < LARGEST_TURN - 1e-6
    assert possible.mean() >= 0.75
    wanted = law.acceleration(torque)
    missed = np.linalg.norm(law.acceleration(law.torque(command)) - wanted, axis=(1, 2))
    # the posture accelerates joints by some 100 rad/s², of which rounding is a part
    assert (missed < law.rounding[:, 0] * max(100, abs(wanted).max()))[possible].all()


@given(seed=SEEDS, kp=KPS, kd=KDS)
def test_what_would_take_more_than_half_a_turn_turns_the_same_way(robot, model, seed, kp, kd):
    rng = np.random.default_rng(seed)
    law = Law(robot, model, kp, kd, rng, speed=1.0)
    turn = rng.normal(size=(len(law.pose), len(robot.arms), 3))
    turn *= 4 / np.linalg.norm(turn, axis=2, keepdims=True)
    torque = [
        operational_space_torque(
            *(now.q, now.dq, now.mass(), now.jacobian(), now.bias()),
            *(np.pad(turn[:, i], ((0, 0), (3, 0))), 0.0, 0.0, arm.posture, kp, kd),
        )
        for i, (arm, now) in enumerate(zip(robot.arms, law.arms, strict=True))
    ]
    done = law.turned(law.command(np.concatenate(torque, axis=1)))
    # the first is stretched out, which hides a part of the command
    np.testing.assert_allclose(done[1:], turn[1:] * LARGEST_TURN / 4, atol=1e-6 * (1 + kd / kp))


@given(seed=SEEDS, factor=st.floats(0.1, 10))
def test_rotation_has_gains_of_its_own(robot, model, seed, factor):
    """Four times the stiffness of rotation does what four times the turn does."""
    turn, torques = 0.3, []
    for rotation, angle in ((None, factor * turn), ({"kp": factor, "kd": 1.0}, turn)):
        law = Law(robot, model, 100.0, 20.0, np.random.default_rng(seed), 1.0, rotation)
        pose = law.pose.reshape(-1, POSE_SIZE)
        there = Rotation.from_rotvec([0, 0, angle]).as_matrix() @ pose[:, 3:].reshape(-1, 3, 3)
        command = np.concatenate([pose[:, :3] + [0.1, 0, 0], there.reshape(-1, 9)], axis=1)
        torques.append(law.torque(command.reshape(law.pose.shape)))
    one, other = torques
    assert (abs(one - other) < law.rounding * abs(one).max()).all()


def test_the_jacobian_is_mujocos(robot, model):
    law = Law(robot, model, 1.0, 1.0, np.random.default_rng(0), speed=1.0)
    law.batch.forward()
    for arm, now in zip(robot.arms, law.arms, strict=True):
        dofs = [model.joint(name).dofadr[0] for name in arm.joints]
        body = int(model.site(arm.tool_site).bodyid[0])
        expected = np.concatenate(law.batch.jac(body, now.position), axis=1)[:, :, dofs]
        np.testing.assert_allclose(now.jacobian(), expected, rtol=0, atol=1e-14)
