"""Other people's trainers see a task as they see any vector environment of gymnasium."""

import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, VectorEnv

from t2l.environment.limits import NAMES
from t2l.environment.vector import make_vector
from t2l.errors import ConfigurationError
from t2l.gains import Cell
from tests.defaults import shipped

CELL, SCALE = Cell(512, 24), (0.2, 0.1)


@pytest.fixture(params=["joint_reach", "lift_cube"])
def environments(request):
    return make_vector(shipped(request.param), CELL, SCALE, 3, horizon_s=0.2)


def test_it_is_a_vector_environment(environments):
    assert isinstance(environments, VectorEnv)
    assert environments.metadata["autoreset_mode"] == AutoresetMode.SAME_STEP
    observation, info = environments.reset(seed=0)
    assert observation in environments.observation_space
    assert info == {}
    environments.action_space.seed(0)
    for step in range(1, 11):
        action = environments.action_space.sample()
        observation, reward, terminated, truncated, info = environments.step(action)
        assert observation in environments.observation_space
        assert reward.shape == (3,)
        assert not terminated.any()
        assert truncated.all() == (step == 10)
    last = np.stack(info["final_obs"])
    assert last.dtype == np.float32
    assert not np.array_equal(last, observation)
    for name in ("success", *NAMES):
        assert info[name].shape == (3,)
        assert info[f"_{name}"].all()


def test_a_seed_repeats_starts_and_goals_and_another_one_does_not(environments):
    first, again, other = (environments.reset(seed=seed)[0] for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert not np.array_equal(first, other)
    # without one the next episodes are new
    assert not np.array_equal(environments.reset()[0], other)


def test_a_failure_terminates_and_does_not_truncate():
    task = shipped("lift_cube")
    environments = make_vector(task, CELL, SCALE, 2, horizon_s=0.2)
    environments.reset(seed=0)
    cube = task.model.joint("cube").qposadr[0]
    environments.environment.simulator.batch.qpos[1, cube] = 2.0
    _, _, terminated, truncated, info = environments.step(np.zeros((2, 8), np.float32))
    assert terminated.tolist() == [False, True]
    assert not truncated.any()
    assert info["_success"].tolist() == [False, True]
    assert info["final_obs"][0] is None


def test_scales_are_one_for_each_group_of_joints():
    with pytest.raises(ConfigurationError, match="action scale: found"):
        make_vector(shipped("joint_reach"), CELL, (0.2,), 2)
