"""Policies side by side learn what stable-baselines3's PPO does, and leave each other alone."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecNormalize

from t2l.gains import Cell
from t2l.rl.adaptive_rate import AdaptiveRate, adapted
from t2l.rl.algorithm import Trained, TrainingEnded, TrainingError
from t2l.rl.evaluate import evaluate, evaluate_side_by_side
from t2l.rl.hyperparameters import COLUMNS, GAMMA, REACH
from t2l.rl.normaliser import Normaliser
from t2l.rl.ppo import export, make_model
from t2l.rl.ppo_side_by_side import Rollout, SideBySide, advantages
from t2l.rl.problem import Choice
from t2l.rl.side_by_side import (
    Training,
    judge_side_by_side,
    learn_alone,
    learn_side_by_side,
)
from tests.defaults import learning, shipped
from tests.policies.made import Reused
from tests.rl.test_environments import make
from tests.rl.test_tuning import PROBLEM

EACH = 16


class Remember(BaseCallback):
    """The rollout that a model learns from, and how it went."""

    def _on_step(self):
        return True

    def _on_rollout_end(self):
        buffer = self.model.rollout_buffer
        self.rewards, self.starts = buffer.rewards.copy(), buffer.episode_starts.copy()
        self.last = self.locals["values"], self.locals["dones"]

        def samples(name):
            values = getattr(buffer, name)
            # stable-baselines3 counts samples by environment, then by step
            return torch.as_tensor(values.swapaxes(0, 1).reshape(1, -1, *values.shape[2:]).copy())

        self.rollout = Rollout(
            samples("observations"), samples("actions"),
            *(samples(name) for name in ("log_probs", "values", "advantages", "returns")),
        )  # fmt: skip
        self.steps = {k: getattr(buffer, k).copy() for k in ("values", "advantages")}


@pytest.fixture(params=[True, False], ids=["shared", "separate"])
def learned(request, monkeypatch):
    """A model after one update, what it learned from, and in which order."""
    orders, permutation = [], np.random.permutation

    def remembered(n):
        orders.append(permutation(n))
        return orders[-1]

    monkeypatch.setattr(np.random, "permutation", remembered)
    model = make_model(make(n=EACH, horizon_s=0.3), seed=3, shared=request.param)
    AdaptiveRate(model, REACH.learning_rate, REACH.target_kl, REACH.minibatches)
    seen = Remember()
    model.learn(REACH.rollout_steps * EACH, seen, log_interval=None)
    return model, seen, orders, request.param


def parameters(model, side):
    names = dict(model.policy.named_parameters())
    ours = side.stack.named(side.stack.rows[0])
    return [(names[name.removeprefix("policy.")], value) for name, value in ours.items()]


def test_an_update_is_that_of_stable_baselines3(learned):
    model, seen, orders, shared = learned
    side = SideBySide(make(n=EACH, horizon_s=0.3), [3], shared)
    before = side.stack.rows.detach().clone()
    fresh = make_model(make(n=EACH, horizon_s=0.3), seed=3, shared=shared)
    for theirs, ours in parameters(fresh, side):
        torch.testing.assert_close(ours, theirs)
    side.learn(seen.rollout, [torch.as_tensor(order) for order in orders])
    assert (side.stack.rows - before).abs().max() > 1e-3
    for theirs, ours in parameters(model, side):
        torch.testing.assert_close(ours, theirs, atol=2e-5, rtol=1e-3)


def test_advantages_are_those_of_stable_baselines3(learned):
    model, seen, *_ = learned
    done = np.concatenate([seen.starts[1:], seen.last[1][None]]).astype(bool)
    assert done.any()
    last = model.policy.predict_values(torch.as_tensor(model._last_obs))[:, 0]
    # of the policy before it learned; the buffer knows it by the last advantage
    value, wanted = (torch.as_tensor(seen.steps[name])[None] for name in ("values", "advantages"))
    reward = torch.as_tensor(seen.rewards)[None]
    after = (wanted[:, -1] - reward[:, -1] + value[:, -1]) / GAMMA
    assert after.shape[1:] == last.shape
    after = torch.where(torch.as_tensor(done[-1]), 0.0, after)
    found = advantages(reward, value, after, torch.as_tensor(done)[None])
    torch.testing.assert_close(found, wanted, atol=1e-5, rtol=1e-4)


def test_observations_and_rewards_are_normalised_as_by_stable_baselines3():
    theirs, plain = (
        VecNormalize(make(n=EACH, horizon_s=0.3), gamma=GAMMA),
        make(n=EACH, horizon_s=0.3),
    )
    ours = Normaliser(1, plain.observation_size, torch.device("cpu"))
    expected = theirs.reset()
    np.testing.assert_allclose(
        ours.seen(torch.as_tensor(plain.reset())[None])[0], expected, atol=1e-5
    )
    generator, ended = np.random.default_rng(0), 0
    for _ in range(40):
        action = generator.uniform(-1, 1, (EACH, 7))
        expected, paid, done, infos = theirs.step(action)
        observation, reward, _, own = plain.step(action)
        np.testing.assert_allclose(
            ours.seen(torch.as_tensor(observation)[None])[0], expected, atol=1e-4
        )
        found = ours.paid(torch.as_tensor(reward)[None], torch.as_tensor(done)[None])
        np.testing.assert_allclose(found[0], paid, rtol=1e-4, atol=1e-5)
        for theirs_of, ours_of in zip(infos, own, strict=True):
            if "terminal_observation" in ours_of:
                last = torch.as_tensor(ours_of["terminal_observation"])[None, None]
                found = ours.seen(last, learn=False)[0, 0]
                np.testing.assert_allclose(found, theirs_of["terminal_observation"], atol=1e-4)
                ended += 1
    assert ended >= EACH


def trainings(*choices, updates=3, cells=None, **changes):
    sizes = {"environments": 64, "updates": updates, "evaluate_every": updates}
    settings = learning(**sizes | changes)
    cells = cells or [PROBLEM.cell] * len(choices)
    return [
        Training(replace(PROBLEM, cell=cell), choice, replace(settings, seed=seed))
        for seed, (choice, cell) in enumerate(zip(choices, cells, strict=True))
    ]


GOOD, BAD = Choice((0.2, 0.1)), Choice((0.3, 0.2))


def test_training_side_by_side_pays():
    first, second = learn_side_by_side(trainings(GOOD, BAD, updates=30))
    for trained in (first, second):
        assert isinstance(trained, Trained)
    again = learn_side_by_side(trainings(GOOD, BAD, updates=1))
    assert first.history.reward.iloc[-1] > again[0].history.reward.iloc[-1] + 0.1
    assert first.policy.action_scale.tolist() == [0.2] * 4 + [0.1] * 3
    # of a second, as its terms are
    terms = first.history.filter(like="reward_").sum(axis=1)
    np.testing.assert_allclose(first.history.reward, terms, rtol=1e-4)
    assert second.policy.action_scale.tolist() == [0.3] * 4 + [0.2] * 3


def test_trainings_do_not_touch_each_other():
    def of_first(*others):
        return learn_side_by_side(trainings(GOOD, *others))[0]

    beside, another = of_first(BAD), of_first(Choice((1e-3, 1e-3)))
    np.testing.assert_array_equal(beside.policy.weights[0], another.policy.weights[0])
    assert beside.evaluation == another.evaluation


def test_an_update_keeps_nothing_of_what_the_next_one_overwrites(monkeypatch):
    expected = learn_side_by_side(trainings(GOOD, BAD))
    monkeypatch.setattr("t2l.rl.ppo_side_by_side.Captured", Reused)
    for one, other in zip(expected, learn_side_by_side(trainings(GOOD, BAD)), strict=True):
        np.testing.assert_array_equal(one.policy.weights[0], other.policy.weights[0])
        assert one.history.drop(columns="seconds").equals(other.history.drop(columns="seconds"))


def test_each_is_judged_in_its_own_cell_as_it_is_alone():
    stiff, soft = trainings(GOOD, GOOD, cells=[Cell(512, 16), Cell(16, 1)])
    policies = [one.policy for one in learn_side_by_side([stiff, soft])]
    found = judge_side_by_side([stiff, soft], policies)
    for training, policy, together in zip([stiff, soft], policies, found, strict=True):
        alone = training.problem.environments(
            training.choice, training.settings, 100, training.settings.seed + 2
        )
        assert evaluate(policy, alone) == together
    with pytest.raises(AssertionError):
        assert found[0] == found[1]


def test_many_policies_act_as_each_does():
    one, two = trainings(GOOD, BAD)
    policies = [trained.policy for trained in learn_side_by_side([one, two])]
    world = make(n=4, horizon_s=0.2)
    (found,) = evaluate_side_by_side(policies[:1], world)
    assert found == evaluate(policies[0], make(n=4, horizon_s=0.2))


def test_they_end_where_one_more_evaluation_would_come_too_late():
    short = {"environments": 4, "evaluate_every": 1}
    for trained in learn_side_by_side(trainings(GOOD, BAD, limit_s=1e-3, **short)):
        assert list(trained.history["update"]) == [1]


def test_one_that_fails_or_is_ended_leaves_the_others(monkeypatch):
    def give_up(update, policy, found):
        raise TrainingEnded

    good, other, broken = trainings(GOOD, GOOD, GOOD)
    begin = SideBySide._act

    def poisoned(self):
        rollout, reward = begin(self)
        rollout.returns[2] = torch.nan
        return rollout, reward

    monkeypatch.setattr(SideBySide, "_act", poisoned)
    kept, ended, failed = learn_side_by_side([good, replace(other, report=give_up), broken])
    assert isinstance(kept, Trained)
    assert np.isfinite(kept.policy.weights[0]).all()
    assert isinstance(ended, TrainingEnded)
    assert isinstance(failed, TrainingError)
    assert "update 1 left a policy that is not finite" in str(failed)


def test_rates_adapt_one_by_one():
    rate = torch.tensor([1e-3, 1e-3, 1e-3, 1e-2])
    rate = adapted(rate, torch.tensor([1.0, 0.01, 1e-4, 1e-4]), target_kl=0.01)
    torch.testing.assert_close(rate, torch.tensor([1e-3 / 1.5, 1e-3, 1.5e-3, 1e-2]))


def test_a_task_of_another_column_learns_as_by_stable_baselines3_and_is_not_normalised():
    task = shipped("joint_reach")
    task.hyperparameters = "drawer"
    column = COLUMNS["drawer"]
    side = SideBySide(make(task, n=4, horizon_s=0.3), [3], True)
    model = make_model(make(task, n=4, horizon_s=0.3), 3, True, column)
    for theirs, ours in parameters(model, side):
        torch.testing.assert_close(ours, theirs)
    assert sum(layer.weight.shape[0] for layer in model.policy.features_extractor.layers[::2]) == (
        256 + 128 + 64
    )
    assert (model.n_steps, model.batch_size, model.vf_coef) == (96, 4, 2.0)
    side.update()
    (ours,), theirs = side.export(), export(model)
    for policy in (ours, theirs):
        assert not policy.mean.any()
        np.testing.assert_allclose(policy.deviation, 1.0, atol=1e-8)


@pytest.mark.slow
def test_both_reach_the_same_success_from_the_same_table():
    """At the sizes of the default study; a minute of a core."""
    problem = replace(PROBLEM, horizon_s=4.0)
    settings = learning(environments=512, updates=40, evaluate_every=40)
    own = [Training(problem, GOOD, replace(settings, seed=seed)) for seed in (1000, 2000)]
    for trained in (learn_side_by_side(own), [learn_alone(one) for one in own]):
        policies = [one.policy for one in trained]
        assert all(found.success >= 0.95 for found in judge_side_by_side(own, policies))
