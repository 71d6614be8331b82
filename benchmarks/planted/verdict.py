"""What advice is worth in worlds whose policies were trained: the rule, and what it finds.

The rule, written before any world was run on the borrowed machine:

1. Success of a cell is the mean over its `POLICIES` policies (the replicates) of their share of
   successes; of policies tried a second time that second time alone counts, for the first one chose
   them. The best cell is chosen by the mean of one half of the policies and its success read off
   the other half, and the other way round: the mean of both. No cell is judged by what chose it.
2. Advice holds in a world if the success of the cell that it names, over the same policies, is not
   more than `WITHIN` below the best cell's. It is right if it holds in `SHARE` of the test worlds.
   The unit is the world.
3. A cell that is ruled out fails if its success is at most `FAILED` of the best cell's. The
   exclusions are right if `SHARE` of all that are ruled out in test worlds fail.
4. Of each pair of cells that are left, advice states the chance that the one of the smaller
   predicted error is better. Pairs are put in bins by it; it is calibrated if in each bin with
   pairs of half of the worlds the stated chance lies in the 95 % interval of the measured share,
   worlds being resampled. Equal successes count half.
5. Advice is given the nominal model, the demonstrations and their gains (`nominal`), or besides it
   the true effects with numbers that are off by 5 % (`explained`).

Beside it, under 2: critical damping at `WISHED_HZ`; the gains that such robots are used with; the
mean of the compliant and overdamped quarter; the largest Kd/Kp, of all and of what is left; the
least validation loss, which needs the trainings; and the mean of what is left.
"""

import tempfile
from argparse import Namespace
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks.from_truth import true_numbers
from benchmarks.planted.cloned import POLICIES
from benchmarks.planted.episode import POLICY_HZ, ROWS_HZ
from benchmarks.planted.shown import Demonstration, demonstrations
from benchmarks.planted.world import World
from t2l.advise.advice import POSES, Advice, Asked, advised
from t2l.advise.evidence import Planted, evidence
from t2l.advise.grid import of as grid_of
from t2l.advise.shown import COMMANDED, Shown
from t2l.cli.advice_inputs import body_of
from t2l.identify.model import Model, from_vector
from t2l.stats.planted import EXPLAINED, NOMINAL, WITHIN

SHARE, FAILED = 0.9, 0.5
WISHED_HZ = 5.0
OFF = 0.05  # standard deviation of the logarithm of a number that was explained


def verdicts(table: pd.DataFrame) -> list[Planted]:
    """Of each half and what was known, by rows of `judged`."""
    found = []
    for (half, known), own in table.groupby(["half", "known"], sort=False):
        lost = {key: own.best - own[key] for key in ("advised", "critical", "ratio")}
        shares = [
            value
            for one in lost.values()
            for value in (int((one <= WITHIN).sum()), float(one.mean()))
        ]
        counts = (int(own[key].sum()) for key in ("ruled_out", "failed", "best_ruled_out"))
        found.append(Planted(half, known, len(own), *shares, *counts))
    return found


def success(table: pd.DataFrame, world: World) -> np.ndarray:
    """(cell, policy) by rule 1."""
    own = table[table.world == world.name]
    cells = ["kp", "kd", "policy"]
    # what chose a policy to be tried again does not count
    counts = own.groupby([*cells, own.stage > 0])[["successes", "rollouts"]].sum()
    last = counts.groupby(cells).last()
    share = last.successes / last.rollouts
    return np.array([[share[kp, kd, i] for i in range(POLICIES)] for kp, kd in world.cells])


def validation(table: pd.DataFrame, world: World) -> np.ndarray:
    """(cell,) mean loss of its policies."""
    means = table[table.world == world.name].groupby(["kp", "kd"]).validation_loss.mean()
    return np.array([means[cell] for cell in world.cells])


def best(found: np.ndarray) -> float:
    """The best cell's success by rule 1, of (cell, policy)."""
    halves = found[:, ::2].mean(axis=1), found[:, 1::2].mean(axis=1)
    return float(np.mean([one[other.argmax()] for one, other in (halves, halves[::-1])]))


def advice_on(world: World, known: str, folder: Path, shown: Sequence[Demonstration]) -> Advice:
    """What `t2l advise` answers, by rule 5."""
    path = folder / f"{world.name}.xml"
    path.write_text(world.mjcf)
    model = Model(str(path), {}, ())
    if known == EXPLAINED:
        rng = world.rng(3)
        hidden = [
            {"effect": type(e).__name__, **_off(asdict(e), rng)} for e in world.hidden
        ]  # fmt: skip
        found = true_numbers(hidden, model, world.joints)
        if found is None:
            raise ValueError(f"{world.name} hides what t2l has no numbers for")
        model = from_vector(model, *found, world.joints)
    states = [np.repeat(one.observation, ROWS_HZ // POLICY_HZ, axis=0) for one in shown]
    motions = [[getattr(one, key) for one in shown] for key in ("q", "dq", "torque")]
    seen = Shown(float(ROWS_HZ), *motions, states, COMMANDED)
    body = body_of(Namespace(robot=str(path), joints=list(world.joints)))
    return advised(
        Asked(
            model=model, joints=world.joints, poses=seen.poses(POSES),
            grid=grid_of(world.kp, world.kd), units=body.units,
            control_rate_hz=float(world.control_rate_hz), policy_rate_hz=float(POLICY_HZ),
            compensated=True, ranges=body.ranges, velocity_limit=body.velocity,
            torque_limit=body.torque, shown=seen, known=known == EXPLAINED,
        )
    )  # fmt: skip


def _off(values: Mapping, rng: np.random.Generator) -> dict:
    def blurred(value):
        if isinstance(value, Mapping):
            return {key: blurred(one) for key, one in value.items()}
        if isinstance(value, tuple):
            return tuple(map(blurred, value))
        if isinstance(value, float):
            return value * float(np.exp(OFF * rng.normal()))
        return value

    return {key: blurred(value) for key, value in values.items()}


def named(world: World, found: np.ndarray, loss: np.ndarray, left: np.ndarray) -> dict[str, float]:
    """Success by the rules that people use, of (cell, policy)."""
    means = found.mean(axis=1)
    kp, kd = np.array(world.cells).T
    inertia = _inertia(world)
    omega = 2 * np.pi * WISHED_HZ
    middle_kp, middle_kd = np.median(world.kp), np.median(world.kd)

    def nearest(wished_kp: float, wished_kd: float) -> int:
        return int(np.hypot(np.log(kp / wished_kp), np.log(kd / wished_kd)).argmin())

    usual = (float(np.exp(np.log(gain).mean())) for gain in (world.usual_kp, world.usual_kd))
    return {
        "critical": means[nearest(inertia * omega**2, 2 * inertia * omega)],
        "usual": means[nearest(*usual)],
        "compliant": means[(kp < middle_kp) & (kd > middle_kd)].mean(),
        "ratio": means[(kd / kp).argmax()],
        "ratio_left": means[np.where(left, kd / kp, -1).argmax()],
        "validation": means[loss.argmin()],
        "left": means[left].mean(),
    }


def _inertia(world: World) -> float:
    """kg·m² of a mean joint of the nominal robot."""
    return float(np.exp(np.log(world.recorded_kd**2 / (4 * world.recorded_kp)).mean()))


def judged(world: World, table: pd.DataFrame) -> tuple[list[dict], list[dict]]:
    """A row a kind of knowledge, and for each a row a stated chance of pairs that are left."""
    rows, pairs = [], []
    with tempfile.TemporaryDirectory() as folder:
        shown = demonstrations(world)
        found, loss = success(table, world), validation(table, world)
        means, top = found.mean(axis=1), best(found)
        for known in (NOMINAL, EXPLAINED):
            advice = advice_on(world, known, Path(folder), shown)
            ruled = advice.ruled_out
            rows.append(
                {
                    "world": world.name, "known": known, "best": top,
                    "advised": means[advice.best], "named": advice.best,
                    "own": len(advice.own), "ruled_out": int(ruled.sum()),
                    "failed": int((means[ruled] <= FAILED * top).sum()),
                    "best_ruled_out": bool(ruled[means.argmax()]),
                    **named(world, found, loss, advice.left),
                }
            )  # fmt: skip
            pairs += _pairs(world, known, advice, means)
    return rows, pairs


def _pairs(world: World, known: str, advice: Advice, means: np.ndarray) -> list[dict]:
    left, found = np.flatnonzero(advice.left), []
    for a, i in enumerate(left):
        for j in left[a + 1 :]:
            first, second = (i, j) if advice.score[i] <= advice.score[j] else (j, i)
            stated = evidence().right(float(advice.score[second] / advice.score[first])).right
            agree = (1 + np.sign(means[first] - means[second])) / 2
            found.append((stated, agree))
    rows = []
    for stated in sorted({one for one, _ in found}):
        agree = [right for one, right in found if one == stated]
        rows.append(
            {"world": world.name, "known": known, "stated": stated, "pairs": len(agree),
             "right": float(np.mean(agree))}
        )  # fmt: skip
    return rows
