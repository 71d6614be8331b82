"""A training step of the nominal policy, against the floor of its arithmetic.

The floor is the time that its matrix products would take at the rate of one large product: their
floating-point operations, of forward and backward pass, over that rate. Beside it stand the
products themselves, one after another as the step has them. One thread, as jobs of the workflow
have. Time is the processor's, which others on the machine disturb less.
"""

import time
from collections.abc import Callable
from statistics import median

import numpy as np
import pandas as pd
import torch
from torch.utils._python_dispatch import TorchDispatchMode
from torch.utils.flop_counter import FlopCounterMode

from benchmarks.scene import block_stack, paper
from t2l.policies import Episode
from t2l.policies.chunk_cvae import Settings, Sizes
from t2l.policies.chunk_cvae_network import ChunkCVAENetwork
from t2l.policies.rows import Rows
from t2l.policies.training import reproducible, train

SIDE_BY_SIDE = (1, 4, 12)
# of all policies together
STEPS = 60
REPEATS = 5
# of the large square product: beyond, the rate hardly rises
LARGE = 1024


class Products(TorchDispatchMode):
    """Keeps the matrix products that are computed within, and does them again.

    Attributes:
        kept: functions and what they were given.
    """

    WANTED = {getattr(torch.ops.aten, name).default for name in ("mm", "addmm", "bmm", "baddbmm")}

    def __init__(self):
        super().__init__()
        self.kept = []

    def __torch_dispatch__(self, func, types, args=(), kwargs=None):
        """See `TorchDispatchMode`."""
        if func in self.WANTED:
            self.kept.append((func, args))
        return func(*args, **(kwargs or {}))

    @torch.no_grad()
    def again(self) -> None:
        """The same products of the same numbers."""
        for function, arguments in self.kept:
            function(*arguments)


def run() -> pd.DataFrame:
    """Medians over interleaved repeats, so that a drifting machine shifts all sides alike."""
    with reproducible(threads=1):
        return pd.DataFrame([_row(count) for count in SIDE_BY_SIDE])


def _row(count: int) -> dict:
    steps = STEPS // count
    with FlopCounterMode(display=False) as counter, Products() as products:
        _training(count, 1)()
    operations, large = counter.get_total_flops(), torch.randn(LARGE, LARGE)
    sides = (_training(count, steps), products.again, lambda: large @ large)
    for side in sides:
        side()
    times = np.array([[_seconds(side) for side in sides] for _ in range(REPEATS)])
    times[:, 0] /= steps
    rate = 2 * LARGE**3 / times[:, 2]
    floor = operations / rate
    return {
        "policies side by side": count,
        "step, ms": f"{1e3 * median(times[:, 0]):.2f}",
        "its products, GFLOP": f"{operations / 1e9:.2f}",
        "one large product, GFLOP/s": f"{median(rate) / 1e9:.0f}",
        "floor, ms": f"{1e3 * median(floor):.2f}",
        "the products alone, ms": f"{1e3 * median(times[:, 1]):.2f}",
        "step over floor (min to max)": _ratio(times[:, 0] / floor),
        "step over products (min to max)": _ratio(times[:, 0] / times[:, 1]),
    }


def _training(count: int, steps: int) -> Callable[[], object]:
    """An epoch of `steps` steps of `count` policies, on data of Block Stack's shape."""
    nominal = {key: paper()["training"][key] for key in Settings.model_fields}
    settings = Settings(**{**nominal, "epochs": 1})
    size, rng = settings.batch_size, np.random.default_rng(0)
    task = block_stack()
    shape = len(task.observation_names), len(task.robot.joints) + len(task.opened)

    def episode(length: int) -> Episode:
        return Episode(*(rng.normal(size=(length, n)).astype(np.float32) for n in shape))

    # next to nothing is held out, so that a step is what an epoch takes
    shown, held_out = [episode(steps * size) for _ in range(count)], episode(1)
    data = Rows([*shown, held_out], settings, torch.device("cpu"))
    training, validation = [data.of([e]) for e in shown], [data.of([held_out])] * count
    sizes = Sizes(
        observation_size=shape[0],
        action_size=shape[1],
        **settings.model_dump(include=set(Sizes.model_fields)),
    )
    networks = [ChunkCVAENetwork(sizes, settings) for _ in range(count)]
    return lambda: train(networks, data, training, validation, settings, range(count))


def _seconds(call: Callable[[], object]) -> float:
    start = time.process_time()
    call()
    return time.process_time() - start


def _ratio(values: np.ndarray) -> str:
    return f"{median(values):.2f} ({min(values):.2f} to {max(values):.2f})"
