import numpy as np
import pytest

from t2l.actions import ACTIONS
from t2l.errors import ConfigurationError
from t2l.gains import Cell
from t2l.identify.training_simulator import Simulator
from t2l.rl.constraints import NAMES
from t2l.rl.environments import Environments
from t2l.rl.interface import scale_per_joint
from t2l.robots import make_robot
from t2l.robots.plant import position_controlled
from tests.defaults import shipped

CELL = Cell(128, 16)
ROBOT = make_robot("fr3")
CENTRE = ROBOT.home
PARAMETERS = {
    name: np.full(7, value)
    for name, value in {
        "stiffness": 120.0, "damping": 15.0, "armature": 0.1, "static_friction": 0.3,
        "dynamic_friction_ratio": 0.8, "viscous_friction": 0.3,
    }.items()
}  # fmt: skip


def joint_delta(scale):
    names = [f"q_des.{joint}" for joint in ROBOT.joints]
    return ACTIONS.find("joint_delta")(names, scale, ROBOT.position_limit)


def make(task=None, n=4, **changes):
    scale = scale_per_joint(changes.pop("action_scale", (0.3, 0.2)), ROBOT)
    arguments = {
        "task": task or shipped("joint_reach"), "cell": CELL, "parameters": PARAMETERS,
        "actions": joint_delta(scale), "n": n, "seed": 0, "horizon_s": 4.0,
        "policy_rate_hz": 50.0, "rate_hz": 100, "staggered": False,
    } | changes  # fmt: skip
    return Environments(**arguments)


def test_an_action_moves_the_simulator_as_its_command_does():
    environments = make(n=1)
    start = np.array([CENTRE])
    environments.place(start, start + 0.2)
    simulator = Simulator(ROBOT, position_controlled(ROBOT), 1, 100)
    simulator.set_parameters(PARAMETERS)
    simulator.qpos[:] = start
    action = np.linspace(-1, 1, 7)[None]
    scale = np.array([0.3] * 4 + [0.2] * 3)
    for _ in range(5):
        observation, *_ = environments.step(action)
        simulator.step(simulator.qpos + scale * action, nstep=2)
    np.testing.assert_allclose(observation[0, :7], simulator.qpos[0], rtol=1e-6)
    np.testing.assert_allclose(observation[0, 14:21], start[0] + 0.2 - simulator.qpos[0], rtol=1e-5)


@pytest.mark.parametrize("task", ["joint_reach", "end_effector_reach"])
def test_an_episode_ends_by_its_length_and_tells_how_it_went(task):
    environments = make(shipped(task), horizon_s=0.2)
    environments.reset()
    for step in range(10):
        observation, reward, done, infos = environments.step(np.zeros((4, 7)))
        assert done.all() == (step == 9)
    for i, info in enumerate(infos):
        assert info["TimeLimit.truncated"]
        assert not info["success"]
        assert {info[name] for name in NAMES} == {0.0}
        # a new goal, while what was seen last belongs to the old one
        assert not np.array_equal(info["terminal_observation"], observation[i])
    assert np.isfinite(reward).all()


def test_whoever_starts_at_the_goal_and_stays_succeeds():
    environments = make(horizon_s=0.2)
    start = np.tile(CENTRE, (4, 1))
    environments.place(start, start)
    for _ in range(10):
        *_, infos = environments.step(np.zeros((4, 7)))
    assert all(info["success"] for info in infos)


def test_wild_actions_violate_and_the_shares_say_so():
    environments = make(cell=Cell(512, 1), action_scale=(1.0, 1.0), horizon_s=0.4)
    environments.reset()
    for k in range(20):
        *_, infos = environments.step(np.full((4, 7), (-1.0) ** k))
    assert all(0.5 < info["torque"] <= 1 for info in infos)
    assert all(0.3 < info["torque_rate"] <= 1 for info in infos)


def test_the_same_seed_gives_the_same_episodes_on_any_number_of_threads():
    def run(seed, threads):
        environments = make(n=8, seed=seed, threads=threads, randomisation=0.1, staggered=True)
        environments.reset()
        generator = np.random.default_rng(1)
        return [environments.step(generator.uniform(-1, 1, (8, 7)))[0] for _ in range(30)]

    np.testing.assert_array_equal(run(0, 1), run(0, 2))
    assert not np.array_equal(run(0, 1), run(1, 1))


def test_randomised_parameters_stay_within_their_fraction():
    environments = make(n=200, randomisation=0.1)
    stiffness = environments.simulator.batch.expand("actuator_gainprm")[:, :, 0]
    assert 0.9 * 120 <= stiffness.min() < 0.92 * 120
    assert 1.08 * 120 < stiffness.max() <= 1.1 * 120


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"policy_rate_hz": 30.0}, "policy rate: found 30 Hz; allowed: a divisor"),
    ],
)
def test_what_cannot_work_is_refused(change, message):
    with pytest.raises(ConfigurationError, match=message):
        make(**change)
