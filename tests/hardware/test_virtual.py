import numpy as np

from t2l.hardware.virtual import VirtualRobot
from t2l.hardware.virtual_physics import PATH, read
from t2l.robots.fr3 import HOME, JOINTS, TORQUE_LIMIT
from tests.conftest import ROOT

Q = np.array(HOME)


def test_it_rests_where_it_starts():
    robot = VirtualRobot()
    state = robot.start(Q, 64.0, 8.0)
    for _ in range(25):
        state = robot.step(Q, 0.02)
    # an offset of up to 0.3 N·m is below the friction that holds the joints
    assert np.abs(state.q - Q).max() < 1e-3
    assert np.abs(state.dq).max() < 1e-3


def test_torque_keeps_its_limits_and_its_rate():
    robot = VirtualRobot()
    robot.start(Q, 512.0, 1.0)
    last = np.zeros((1, 7))
    for k in range(80):
        state = robot.step(Q + (0.4 if k < 40 else -0.4), 0.001)
        assert np.abs(state.tau - last).max() <= 990 * 0.001 + 1e-9
        assert np.all(np.abs(state.tau) <= TORQUE_LIMIT)
        last = state.tau
    assert np.all(np.abs(last[0, 4:]) > 11)


def test_a_command_acts_after_its_latency():
    robot = VirtualRobot()
    robot.start(Q, 64.0, 8.0)
    cycles = round(read().command_latency_s * read().control_rate_hz)
    taus = [np.abs(robot.step(Q + 0.1, 0.001).tau).max() for _ in range(cycles + 1)]
    assert max(taus[:cycles]) < 1e-6 < 0.5 < taus[cycles]


def test_rollouts_side_by_side_do_not_touch_each_other():
    def run(n, which):
        robot = VirtualRobot(n, threads=2)
        robot.start(Q, np.array([[64.0], [256.0]])[which], 8.0)
        for _ in range(10):
            state = robot.step(Q + 0.1, 0.02)
        return state.q

    both = run(2, slice(None))
    np.testing.assert_array_equal(both[:1], run(1, slice(0, 1)))
    assert np.abs(both[0] - both[1]).max() > 1e-3


def test_the_loop_is_converged_in_its_timestep(monkeypatch):
    def end(rate):
        physics = read()
        monkeypatch.setattr(
            "t2l.hardware.virtual.read",
            lambda: type(physics)(**{**vars(physics), "physics_rate_hz": rate}),
        )
        robot = VirtualRobot()
        robot.start(Q, 256.0, 12.0)
        return np.array([robot.step(Q + 0.1, 0.02).q[0] for _ in range(20)])

    coarse, fine = end(4000), end(16000)
    assert np.abs(coarse - fine).max() < 0.01 * 0.1


def test_every_hidden_value_has_a_source_and_only_the_virtual_robot_reads_it():
    import yaml

    for name, entry in yaml.safe_load(PATH.read_text()).items():
        assert entry["source"], name
    readers = [
        path.relative_to(ROOT / "src/t2l")
        for path in (ROOT / "src/t2l").rglob("*.py")
        if "virtual_physics" in path.read_text() or PATH.name in path.read_text()
    ]
    assert sorted(map(str, readers)) == ["sim2real/virtual.py", "sim2real/virtual_physics.py"]
    assert len(JOINTS) == 7
