"""Commands and actions lead to each other, in every space and about every reference."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from t2l.actions import ACTIONS

JOINTS = ["q_des.a", "q_des.b", "q_des.c"]
POSES = [f"x_des.{site}.{i}" for site in ("left", "right") for i in range(12)]
SPACES = [
    ("joint_target", JOINTS, {}),
    ("joint_delta", JOINTS, {"reference": "measured"}),
    ("joint_delta", JOINTS, {"reference": "commanded"}),
    ("joint_delta", JOINTS, {"reference": "home", "home": np.array([0.1, -0.2, 3.0])}),
    ("task_pose", POSES, {}),
    ("task_delta", POSES, {"reference": "measured"}),
    ("task_delta", POSES, {"reference": "commanded"}),
]


def commands(names, rng, n):
    if names is JOINTS:
        return rng.normal(size=(n, len(names)))
    poses = [
        np.concatenate(
            [
                rng.normal(size=(n, 3)),
                Rotation.random(n, random_state=rng).as_matrix().reshape(n, 9),
            ],
            axis=1,
        )
        for _ in range(2)
    ]
    return np.concatenate(poses, axis=1)


@pytest.mark.parametrize(("name", "of", "section"), SPACES)
@given(seed=st.integers(0, 2**31), scale=st.floats(1e-3, 10))
def test_the_action_of_a_command_leads_to_the_command(name, of, section, seed, scale):
    rng = np.random.default_rng(seed)
    wanted, measured, before = (commands(of, rng, 4) for _ in range(3))
    space = ACTIONS.find(name)(of, scale=scale, **section)
    action = space.action(wanted, measured, before)
    assert action.shape == (4, len(space.names))
    assert len(set(space.names)) == len(space.names)
    found = space.command(action, measured, before)
    np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-9)


@given(seed=st.integers(0, 2**31), scale=st.floats(1e-3, 5))
def test_commands_never_leave_their_limits(seed, scale):
    rng = np.random.default_rng(seed)
    limits = np.array([[-1.0, 0.5], [-0.2, 0.2], [0.0, 2.0]])
    measured = rng.uniform(*limits.T, (3, 3))
    action = rng.uniform(-1, 1, (3, 3))
    space = ACTIONS.find("joint_delta")(JOINTS, scale, limits)
    command = space.command(action, measured, measured)
    assert ((command >= limits[:, 0]) & (command <= limits[:, 1])).all()
    free = measured + scale * action
    within = (free >= limits[:, 0]) & (free <= limits[:, 1])
    np.testing.assert_array_equal(command[within], free[within])


def test_what_is_no_number_stays_so():
    space = ACTIONS.find("joint_delta")(JOINTS, 1.0, np.tile([-1.0, 1.0], (3, 1)))
    command = space.command(np.array([[0.0, np.nan, 0.0]]), np.zeros((1, 3)), np.zeros((1, 3)))
    assert np.isnan(command).tolist() == [[False, True, False]]


def test_a_pose_that_is_no_rotation_becomes_the_nearest_by_gram_and_schmidt():
    space = ACTIONS.find("task_pose")(POSES[:12])
    action = np.array([[0.1, 0.2, 0.3, 2.0, 0.0, 0.0, 1.0, 3.0, 0.0]])
    command = space.command(action, None, None)
    np.testing.assert_allclose(command[0, 3:].reshape(3, 3), np.eye(3), atol=1e-12)


@pytest.mark.parametrize(
    ("reference", "command", "memory"),
    [("measured", 1.5, []), ("commanded", 2.5, [1.0]), ("home", 0.0, [])],
)
def test_the_studys_three_references(reference, command, memory):
    """x_des = α a + γ β x + γ (1 − β) x_des(t−1), with α a = 0.5, x = 1, x_des(t−1) = 2."""
    space = ACTIONS.find("joint_delta")(
        ["q_des.a"], 0.5, reference=reference, home=np.array([-0.5])
    )
    x, before = np.array([[1.0]]), np.array([[2.0]])
    assert space.command(np.array([[1.0]]), x, before).tolist() == [[command]]
    assert space.memory(x, before).tolist() == [memory]
