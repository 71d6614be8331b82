import pytest


@pytest.mark.parametrize(
    ("section", "keys", "message"),
    [
        (
            "reinforcement_learning",
            {"environments": 16_000, "horizon_s": 60},
            "reinforcement_learning.environments, reinforcement_learning.horizon_s: found "
            "16000 × 60; allowed: a product of at most 200000",
        ),
        ("training", {"history": 1000, "batch_size": 100_000}, "found 100000 × 1010"),
        ("training", {"history": 1000, "hidden": [4096]}, "found 4096 × 1010"),
        ("tuning", {"workers": 1000}, "found 5 × 2 × 1000; allowed: a product of at most"),
    ],
)
def test_sizes_that_are_too_large_together_are_named(config, refused, section, keys, message):
    config[section].update(keys)
    assert message in refused(config)
