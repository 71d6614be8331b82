"""MuJoCo Warp steps as MuJoCo does; here on the processor, where it runs too."""

import numpy as np
import pytest
import torch

from t2l.environment.vector import make_vector
from t2l.gains import Cell
from t2l.robots import make_robot
from t2l.robots.plant import position_controlled
from t2l.sim.arrays import to_numpy
from t2l.sim.batch import apply_position_gains, make_batch
from tests.defaults import shipped
from tests.tasks.scripted import scene, towards

warp_batch = pytest.importorskip(
    "t2l.sim.warp_batch", reason="the extra gpu is not installed", exc_type=ImportError
)

ROBOT = make_robot("fr3")
N = 6
UP = np.array([0.0, 0.0, 1.0])


@pytest.fixture(scope="module")
def batches():
    spec = position_controlled(ROBOT)
    spec.option.timestep = 0.01
    # what Warp is given; the other solver leaves 3e-4 rad of dry friction's error
    spec.option.solver = 2
    model = spec.compile()
    return [make_batch(model, N, device=device) for device in ("mujoco", "cpu")]


def drawn():
    rng = np.random.default_rng(0)
    shape = (N, len(ROBOT.joints))
    start = ROBOT.home + 0.3 * rng.normal(size=shape)
    return {
        "kp": rng.choice([16.0, 512.0], (N, 1)), "kd": rng.choice([2.0, 24.0], (N, 1)),
        "dof_armature": rng.uniform(0.02, 1.0, shape), "dof_damping": rng.uniform(0, 1, shape),
        "dof_frictionloss": rng.uniform(0.0, 2.0, shape),
        "start": start, "command": start + 0.2 * rng.normal(size=shape),
    }  # fmt: skip


def moved(batch, steps, of):
    array = getattr(batch, "asarray", np.asarray)
    apply_position_gains(batch, ROBOT.joints, array(of["kp"]), array(of["kd"]))
    for name in ("dof_armature", "dof_damping", "dof_frictionloss"):
        batch.expand(name)[:] = array(of[name])
    batch.set_const()
    batch.reset()
    batch.qpos[:], batch.ctrl[:] = array(of["start"]), array(of["command"])
    for _ in range(steps):
        batch.step()
    return [to_numpy(values).copy() for values in (batch.qpos, batch.qvel)]


def test_each_simulation_moves_as_in_mujoco_with_parameters_of_its_own(batches):
    of = drawn()
    expected, found = (moved(batch, 100, of) for batch in batches)
    assert np.abs(expected[0] - of["start"]).max() > 0.2
    # single precision, a hundred steps with dry friction
    np.testing.assert_allclose(found[0], expected[0], atol=2e-5)
    np.testing.assert_allclose(found[1], expected[1], atol=2e-4)


def test_joint_limits_hold(batches):
    of = drawn()
    high = ROBOT.position_limit[:, 1]
    of |= {"kp": np.full((N, 1), 16.0), "start": np.tile(high - 0.1, (N, 1))}
    of["command"] = of["start"] + 1.0
    expected, found = (moved(batch, 100, of) for batch in batches)
    assert (expected[0] > of["start"] + 0.05).any()
    np.testing.assert_allclose(found[0], expected[0], atol=1e-4)


def test_some_are_reset_and_the_others_go_on(batches):
    batch = batches[1]
    moved(batch, 3, drawn())
    before = batch.qpos.clone()
    batch.reset(np.array([1, 4]))
    rest = [0, 2, 3, 5]
    assert torch.equal(batch.qpos[rest], before[rest])
    assert not batch.qvel[[1, 4]].any()
    np.testing.assert_allclose(batch.qpos[1], batch.model.qpos0, atol=1e-6)


@pytest.fixture(scope="module")
def grasps():
    """Where two hands are about their cubes, (N, nq), by MuJoCo; and goals above."""
    task = shipped("lift_cube")
    environment, rng = scene(task, 2), np.random.default_rng(0)
    goals = task.sample_goals(rng, 2)
    environment.place(task.sample_starts(rng, 2), goals)
    for step in range(90):
        at = environment.task.measure(environment.simulator.batch, goals).cube
        above = at + (0.1 * UP if step < 50 else 0.0)
        environment.advance(towards(environment, above, True))
    return task, environment.simulator.batch.qpos.copy(), goals


def test_a_hand_lifts_a_cube_as_in_mujoco(grasps):
    task, starts, goals = grasps
    two = [scene(task, 2, device=device) for device in ("mujoco", "cpu")]
    for environment in two:
        environment.place(environment.array(starts), environment.array(goals))
    for step in range(40):
        at = two[0].task.measure(two[0].simulator.batch, goals).cube
        action = towards(two[0], at if step < 15 else goals, False)
        for environment in two:
            environment.advance(environment.array(action))
    expected, found = (to_numpy(environment.simulator.batch.qpos) for environment in two)
    assert (expected[:, task.cube_qpos][:, 2] > starts[:, task.cube_qpos][:, 2] + 0.03).all()
    cubes = [qpos[:, task.cube_qpos][:, :3] for qpos in (found, expected)]
    np.testing.assert_allclose(*cubes, atol=1e-4)
    # what turns about the grip slips, in single precision not as far on every machine
    np.testing.assert_allclose(found, expected, atol=1e-2)


def test_a_humanoid_falls_as_in_mujoco_and_its_feet_feel_the_same():
    task = shipped("track_velocity")
    meaning = {"kind": "joint_delta", "reference": "home"}
    two = [
        make_vector(task, Cell(1, 1), (0.5, 0.5), 2, actions=meaning, device=device).environment
        for device in ("mujoco", "cpu")
    ]
    rng = np.random.default_rng(0)
    starts, goals = task.sample_starts(rng, 2), task.sample_goals(rng, 2)
    for environment in two:
        environment.place(environment.array(starts), environment.array(goals))
    for _ in range(30):
        action = rng.uniform(-1, 1, (2, len(task.robot.joints)))
        rewards = [to_numpy(e.advance(e.array(action))[1]) for e in two]
        np.testing.assert_allclose(*rewards, atol=1e-4)
    states = [to_numpy(environment.simulator.batch.qpos) for environment in two]
    # 120 steps of the physics: it has moved, and stands
    assert np.abs(states[0] - starts).max() > 0.2
    np.testing.assert_allclose(states[1], states[0], atol=1e-4)
    seen, other = (environment._before for environment in two)
    assert seen.stands.any()
    np.testing.assert_array_equal(to_numpy(other.stands), seen.stands)
    np.testing.assert_allclose(to_numpy(other.held_s), seen.held_s, atol=1e-6)
    for name in ("slip", "effort", "jerking"):
        own = getattr(seen, name)
        np.testing.assert_allclose(to_numpy(getattr(other, name)), own, rtol=1e-3, atol=1e-4)


@pytest.mark.parametrize(("above_m", "apart"), [(5.0, 1e-5), (0.0, 0.05)])
def test_a_hand_moves_as_in_mujoco_and_a_cube_much_alike(above_m, apart):
    task = shipped("in_hand_cube")
    meaning = {"kind": "joint_delta", "reference": "home"}
    two = [
        make_vector(task, Cell(1, 1), (0.4, 0.4), 2, actions=meaning, device=device).environment
        for device in ("mujoco", "cpu")
    ]
    rng = np.random.default_rng(0)
    starts, goals = task.sample_starts(rng, 2), task.sample_goals(rng, 2)
    starts[:, task.cube_qpos][:, 2] += above_m
    for environment in two:
        environment.place(environment.array(starts), environment.array(goals))
    action = rng.uniform(-1, 1, (2, len(task.robot.joints)))
    for environment in two:
        command = environment.actions.command(environment.array(action), environment.simulator.q, 0)
        environment.simulator.step(command, 40)
    states = [to_numpy(environment.simulator.batch.qpos) for environment in two]
    assert np.abs(states[0] - starts)[:, task.arm_qpos].max() > 0.2
    # edges on edges: which points touch is decided in single precision
    np.testing.assert_allclose(*(state[:, task.arm_qpos] for state in states), atol=apart)
    away = [to_numpy(environment._measure().away_rad) for environment in two]
    np.testing.assert_allclose(*away, atol=max(apart, 1e-3))


def test_contacts_without_room_are_told(grasps):
    task, starts, _ = grasps
    batch = warp_batch.WarpBatch(task.model, 2, "cpu", contacts=1)
    batch.qpos[:] = batch.asarray(starts)
    batch.step()
    with pytest.raises(warp_batch.ContactOverflowError, match="more than 1 contacts"):
        batch.diverged()
