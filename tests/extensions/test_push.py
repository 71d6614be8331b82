"""A task of one's own with contacts, of terms alone, is learned and judged like the library's."""

import numpy as np

from t2l.environment.vector import make_vector
from t2l.gains import Cell
from t2l.rl.alone import problem_of, settings_of, train_alone
from t2l.tasks import make_task
from tests.defaults import DEFAULTS
from tests.tasks.scripted import RATE_HZ, STIFF, scene, towards

FILE = {"kind": "push", "robot": "fr3_hand", "tolerance_m": 0.03}
ENTRY = {
    "task": "push", "action_scales": [{"kp": 512, "kd": 24, "rad": [0.2, 0.1]}],
    "actions": {"kind": "joint_delta"}, "policy_rate_hz": 50.0, "rate_hz": 200.0, "horizon_s": 0.1,
    "environments": 4, "updates": 1, "evaluate_every": 1, "observation_noise_rad": 0.0,
    "observation_noise_rad_s": 0.0,
}  # fmt: skip


def pushed(behind):
    """Whether a hand that goes down so far behind the cube and then forward brings it there."""
    environment = scene(make_task(FILE), 2)
    starts = environment.task.sample_starts(np.random.default_rng(0), 2)
    cube, goal = np.array([0.45, 0.0, 0.03]), np.array([0.57, 0.0, 0.03])
    starts[:, environment.task.object_qpos[:3]] = cube
    environment.place(starts, np.tile(goal, (2, 1)))
    for step in range(environment.horizon):
        t = step / RATE_HZ
        forward = min(max(t - 2.5, 0.0) * 0.1, goal[0] - cube[0])
        hand = cube + np.array([forward - behind, 0.0, 0.1 * max(1.5 - t, 0.0) / 1.5 + 0.005])
        ended = environment.advance(towards(environment, np.tile(hand, (2, 1)), False))[2]
    return ended.success.tolist()


def test_a_scripted_hand_is_judged_right():
    assert pushed(behind=0.045) == [True, True]
    # it stays clear of the cube all the way
    assert pushed(behind=0.25) == [False, False]


def test_it_is_learned_as_the_librarys_are():
    section = {k: v for k, v in DEFAULTS["reinforcement_learning"].items() if k != "horizon_s"}
    settings = settings_of(section, ENTRY)
    trained, row, episodes = train_alone(*problem_of(ENTRY, FILE, STIFF), settings, seed=1)
    assert {"reward_reaching", "reward_goal", "reward_change"} <= set(trained.history.columns)
    assert row["episodes"] == 100
    assert set(episodes.success) <= {True, False}
    assert episodes.qpos[0].shape == (16,)


def test_other_peoples_trainers_run_on_it():
    environments = make_vector(make_task(FILE), Cell(16, 24), (2.0, 1.0), 3)
    observation, _ = environments.reset(seed=0)
    assert observation.shape == (3, 14 + 6 + 8)
