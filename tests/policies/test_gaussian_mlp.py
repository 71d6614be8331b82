import numpy as np
import pytest

from t2l.errors import ArtefactError
from t2l.rl.policy import load
from tests.transfer.test_deploy import proportional

LAYERS = {
    "mean": np.zeros(28), "deviation": np.ones(28), "action_scale": np.ones(2),
    "weight0": np.ones((9, 28)), "bias0": np.ones(9), "weight1": np.ones((7, 9)),
    "bias1": np.ones(7),
}  # fmt: skip


def test_a_policy_survives_the_disk(tmp_path):
    policy = proportional()
    policy.save(tmp_path / "policy.npz")
    observation = np.random.default_rng(0).normal(size=(5, 28))
    np.testing.assert_array_equal(load(tmp_path / "policy.npz").act(observation),
                                  policy.act(observation))  # fmt: skip


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"bias1": None}, "has no bias1"),
        ({"mean": None}, "lacks mean"),
        ({"weight3": np.ones((7, 7))}, "has no"),
        ({"note": np.ones(1)}, "has note"),
        ({"weight1": np.ones((7, 8))}, r"weight1 has shape \(7, 8\); expected \(7, 9\)"),
        ({"weight0": np.ones(28)}, "weight0 has shape"),
        ({"weight0": np.ones((9, 28, 2))}, "weight0 has shape"),
        ({"bias0": np.array(1.0)}, "bias0 has shape"),
        ({"deviation": np.ones(27)}, "deviation has shape"),
        ({"mean": np.zeros((28, 1))}, "mean has shape"),
        ({"weight1": np.ones((6, 9)), "bias1": np.ones(6)}, "bias1 has shape"),
        ({"action_scale": np.ones(7)}, "action_scale has shape"),
        ({"mean": np.array(["x"] * 28)}, "mean holds <U1"),
    ],
    ids=lambda value: "" if isinstance(value, dict) else value,
)
def test_layers_that_do_not_fit_are_told(tmp_path, change, message):
    arrays = {name: array for name, array in (LAYERS | change).items() if array is not None}
    np.savez(tmp_path / "policy.npz", **LAYERS)
    load(tmp_path / "policy.npz")
    np.savez(tmp_path / "policy.npz", **arrays)
    with pytest.raises(ArtefactError, match=rf"policy.npz: .*{message}"):
        load(tmp_path / "policy.npz")
