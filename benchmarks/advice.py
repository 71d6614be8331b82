"""How well `t2l advise` orders gains for cloning, on grids whose policies were trained.

`python -m benchmarks advice` ranks the cells of every grid by what `t2l.advise.cloning` predicts
from demonstrations (docs/data/label_residuals*.csv), and by simple rules. What the prediction has
fitted, BLEND and CORRELATION, is chosen anew for each task on the other tasks alone. A grid of a
UR5e and the study's own chose nothing: they are ranked with the choice of all tasks of the FR3,
the labels of the study's being those of our task of the same name. With `T2L_STUDY_DATA` naming the
folder with `paper_results.json` it writes src/t2l/advise/evidence.yaml, which the page quotes.

It also plays `t2l advise --train` with the policies of the grids of ours: what PRIOR has fitted is
fitted anew for each grid on the others, and the success of the cell that is named after so many
trainings is compared with the best cell's, and with as many trainings under cells drawn at random.
"""

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.optimize import minimize

from benchmarks.planted.verdict import verdicts
from benchmarks.planted_worlds import ADVISED
from benchmarks.rules import table
from benchmarks.scene import ROOT, task_file
from t2l.advise.action_scale import action_scales
from t2l.advise.attenuation import held_variance, step_matrices
from t2l.advise.beforehand import matrices
from t2l.advise.cloning import BLEND, CORRELATION, blended, difficulty, predicted_error
from t2l.advise.evidence import (
    EVIDENCE,
    OTHER,
    OURS,
    STUDY,
    Evidence,
    Measured,
    Pairs,
    Planted,
    Settling,
    Trials,
    write_evidence,
)
from t2l.advise.exclusions import HOPELESS, MOST_OVERSHOOT
from t2l.advise.loop import Loop, overshoot
from t2l.advise.posterior import PRIOR, Prior, Tried, before, best_cell, next_cell, posterior
from t2l.advise.shown import FREE, Shown, free_torques
from t2l.advise.trainings import to_train
from t2l.config.models.cloning import CloningGrid
from t2l.gains import Cell
from t2l.identify.prediction import with_effects
from t2l.robots import Robot, make_robot
from t2l.sim.batch import TIMESTEP_S
from t2l.stats.rank import spearman
from t2l.study.published.grids import COUNTERPARTS

DATA = ROOT / "docs/data"
GRIDS = {
    "block_stack": "cloning_grid", "dishrack_loading": "dishrack_loading",
    "dishrack_unloading": "dishrack_unloading", "bimanual_handover": "bimanual_handover",
    "mug_hanging": "mug_hanging", "dishwasher": "dishwasher",
}  # fmt: skip
ANOTHER = {"block_stack_ur5e": "ur5e"}
STEPS = 10  # of the simulator, that a command of these policies was held for
BLENDS = (0.0, 0.25, 0.5, 0.75, 1.0)
CORRELATIONS = (0.0, 0.5, 0.8)
PLAYED, TIMES = 8, 20  # trainings, and orders of a cell's policies
SUCCEEDED = 0.95  # reference: of trials, in the study
SECONDS = (1.0, 2.0, 4.0)  # of motions, from brisk to slow for an episode of 5 s
HOLD_S = 0.02
MOTIONS = 50
TRAINED, DRAWN = 3, 10_000  # cells that are drawn at random, and how often
FACTORS = (1.0, 1.25, 1.6, 2.5, 4.0)  # format: between two predicted errors
LOGARITHMIC = ("spread", "own", "length", "policy")  # fields of `Prior`
REGIONS = CloningGrid()
STUDY_NAMES = {theirs: ours for ours, theirs in COUNTERPARTS.items()}


@dataclass(frozen=True)
class Ranked:
    """The cells of a grid, and what ranks them.

    Attributes:
        cells: kp, kd, success.
        inertia: (n,) kg·m² of the joints; positions, displacements: (n, 3, 3) of their labels.
    """

    cells: pd.DataFrame
    inertia: np.ndarray
    positions: np.ndarray
    displacements: np.ndarray

    @property
    def success(self) -> np.ndarray:
        return self.cells.success.to_numpy()

    @cached_property
    def amplification(self) -> dict[float, np.ndarray]:
        """(cell, n) by correlation, in the simulator that the policies ran in."""
        pairs = list(zip(self.cells.kp, self.cells.kd, strict=True))
        return {
            correlation: np.array(
                [
                    [
                        held_variance(*step_matrices(kp, kd, m, TIMESTEP_S), STEPS, correlation)
                        for m in self.inertia
                    ]
                    for kp, kd in pairs
                ]
            )
            for correlation in CORRELATIONS
        }

    def predicted(self, blend: float, correlation: float) -> np.ndarray:
        """(cell,) rad."""
        kp, kd = (self.cells[key].to_numpy()[:, None] + 0 * self.inertia for key in ("kp", "kd"))
        labels = blended(
            *(difficulty(c, kp, kd) for c in (self.positions, self.displacements)), blend
        )
        return predicted_error(self.amplification[correlation], labels)

    def rho(self, blend: float, correlation: float) -> float:
        return float(spearman(-self.predicted(blend, correlation), self.success))

    def off_critical(self) -> np.ndarray:
        """(cell,) |ln ζ| of the joint of median inertia."""
        kp, kd = self.cells.kp.to_numpy(), self.cells.kd.to_numpy()
        return np.abs(np.log(kd / (2 * np.sqrt(kp * np.median(self.inertia)))))


def main(arguments: list[str]) -> pd.DataFrame:
    """One row a grid, then the means over them."""
    if arguments:
        raise SystemExit(f"found {' '.join(arguments)}; allowed: nothing after advice")
    ours = {task: of_ours(task, name) for task, name in GRIDS.items()}
    # none of it looks at the task that it is used for
    choices = [
        (task, OURS, grid, chosen({k: v for k, v in ours.items() if k != task}))
        for task, grid in ours.items()
    ]
    of_all = chosen(ours)
    settling = settled({**ours, **{t: of_ours(t, name) for t, name in ANOTHER.items()}}, of_all)
    if of_all != (BLEND, CORRELATION):
        print(f"t2l.advise.cloning: BLEND, CORRELATION are to be {of_all}", flush=True)
    theirs = of_study(ours)
    choices += [(task, OTHER, of_ours(task, name), of_all) for task, name in ANOTHER.items()]
    choices += [(task, STUDY, grid, of_all) for task, grid in theirs.items()]
    if theirs:
        rows = tuple(measured(*choice) for choice in choices)
        write_evidence(
            Evidence(rows, pairs(choices), trials(), settling, planted()),
            ROOT / "src/t2l/advise" / EVIDENCE,
        )
    else:
        print("T2L_STUDY_DATA does not name the folder of the study's grids: nothing is written")
        rows = tuple(measured(*choice) for choice in choices)
    found = pd.DataFrame([vars(row) for row in rows])
    means = found.groupby("whose", sort=False).mean(numeric_only=True).reset_index()
    return pd.concat([found, means.assign(grid="mean")], ignore_index=True).round(3)


def pairs(choices: Sequence[tuple]) -> tuple[Pairs, ...]:
    """How often the order of two cells is right, by the factor between their predicted errors."""
    shares = []
    for _, _, grid, choice in choices:
        error, success = grid.predicted(*choice), grid.success
        one, other = np.triu_indices(len(error), 1)
        factor = np.exp(np.abs(np.log(error[one] / error[other])))
        agree = np.sign(error[other] - error[one]) * np.sign(success[one] - success[other])
        band = np.searchsorted(FACTORS, factor, side="right") - 1
        right = (1 + agree) / 2
        shares.append([right[band == i].mean() for i in range(len(FACTORS))])
    return tuple(
        Pairs(factor, float(np.mean(each)), float(np.min(each)))
        for factor, each in zip(FACTORS, np.transpose(shares), strict=True)
    )


def settled(grids: Mapping[str, Ranked], choice: tuple[float, float]) -> tuple[Settling, ...]:
    """By trainings, what is lost against the best cell, mean over grids."""
    played = {}
    for task, grid in grids.items():
        one = grid.predicted(*choice), *grid.cells[["kp", "kd"]].to_numpy(float).T, policies(task)
        played[task] = one
    of_all = likeliest([*played.values()])
    print(f"t2l.advise.posterior: PRIOR is to be {of_all}", flush=True)
    lost, drawn = [], []
    for task, one in played.items():
        prior = likeliest([other for name, other in played.items() if name != task])
        lost.append(np.mean([_played(*one, prior, seed) for seed in range(TIMES)], axis=0))
        drawn.append(np.mean([_drawn(*one, seed) for seed in range(10 * TIMES)], axis=0))
    return tuple(
        Settling(n, *(float(np.mean([each[n] for each in rows])) for rows in (lost, drawn)))
        for n in range(PLAYED + 1)
    )


def policies(task: str) -> np.ndarray:
    """(cell, policy) successes, cells as in `Ranked`."""
    table = pd.read_csv(DATA / f"{(GRIDS | ANOTHER)[task]}.csv")
    table = table[table.variant == "nominal"].sort_values(["kp", "kd", "seed"])
    return table.success.to_numpy().reshape(-1, table.seed.nunique())


def likeliest(grids: Sequence[tuple]) -> Prior:
    """The prior under which the successes of grids are most likely."""

    def unlikely(x: np.ndarray) -> float:
        prior, total = Prior(*x[:2], *np.exp(x[2:])), 0.0
        for score, kp, kd, found in grids:
            mean, covariance = before(score, kp, kd, prior)
            count = found.shape[1]
            seen = covariance + prior.policy**2 / count * np.eye(len(mean))
            root = np.linalg.cholesky(seen)
            left = np.linalg.solve(root, found.mean(axis=1) - mean)
            within = ((found - found.mean(axis=1, keepdims=True)) ** 2).sum()
            total += left @ left / 2 + np.log(np.diag(root)).sum() + within / 2 / prior.policy**2
            total += (found.size - len(mean)) * np.log(prior.policy)
        return total

    start = [PRIOR.middle, PRIOR.slope, *np.log([getattr(PRIOR, key) for key in LOGARITHMIC])]
    bounds = [(0.0, 1.2), (0.0, 2.0), (-4, 0), (-4, 0), (-1, 2), (-4, 0)]
    x = minimize(unlikely, start, method="L-BFGS-B", bounds=bounds).x
    return Prior(*(float(f"{value:.3g}") for value in (*x[:2], *np.exp(x[2:]))))


def _played(score, kp, kd, found: np.ndarray, prior: Prior, seed: int) -> list[float]:
    """What is lost after 0 to `PLAYED` trainings; a cell has as many policies as there are."""
    rng = np.random.default_rng(seed)
    left = score < HOPELESS * score.min()
    waiting = [rng.permutation(own).tolist() for own in found]
    means, tried, lost = found.mean(axis=1), [], []
    for _ in range(PLAYED + 1):
        now = posterior(score, kp, kd, tried, prior)
        lost.append(means.max() - means[best_cell(now, left)])
        more = np.array([bool(own) for own in waiting])
        cell = next_cell(now, left & more)
        tried.append(Tried(cell, waiting[cell].pop()))
    return lost


def _drawn(score, kp, kd, found: np.ndarray, seed: int) -> list[float]:
    """The same of cells at random, the best of which is named; with none, of any cell."""
    rng = np.random.default_rng(seed)
    left = np.flatnonzero(score < HOPELESS * score.min())
    means, order = found.mean(axis=1), rng.permutation(left)
    seen = rng.permuted(found, axis=1)[:, 0]
    named = [order[0], *(order[: n + 1][seen[order[: n + 1]].argmax()] for n in range(PLAYED))]
    return [means.max() - means[cell] for cell in named]


def planted() -> tuple[Planted, ...]:
    """What was found in the planted worlds, by half and by what was known."""
    return tuple(verdicts(pd.read_csv(DATA / ADVISED)))


def chosen(grids: Mapping[str, Ranked]) -> tuple[float, float]:
    """The blend and the correlation with the greatest mean ρ over some tasks."""
    pairs = [(blend, correlation) for blend in BLENDS for correlation in CORRELATIONS]
    return max(pairs, key=lambda pair: np.mean([grid.rho(*pair) for grid in grids.values()]))


def trials() -> tuple[Trials, ...]:
    """Trainings of docs/data/landscape.csv, four pairs of gains, by smooth motions of some lengths.

    The starts and goals are of the task as the trainings had it.
    """
    robot, task = make_robot("fr3"), task_file("joint_reach")
    plant = with_effects("fr3", robot.joints)
    friction = plant.dof_frictionloss[[plant.joint(j).dofadr[0] for j in robot.joints]]
    table = pd.read_csv(DATA / "landscape.csv")
    succeeded = (table.success >= SUCCEEDED).to_numpy()
    found = []
    for seconds in SECONDS:
        shown = reaching(robot, task, plant, seconds)
        kp, kd = (table[key].to_numpy(float)[:, None] + np.zeros(7) for key in ("kp", "kd"))
        scales = action_scales(shown, kp, kd, friction, robot.torque_limit, 1)
        given = np.where(
            robot.proximal, table.action_scale_proximal.to_numpy()[:, None],
            table.action_scale_distal.to_numpy()[:, None],
        )  # fmt: skip
        inside = ((given >= scales.low) & (given <= scales.high)).all(axis=1)
        shares = (float(succeeded[which].mean()) for which in (inside, ~inside))
        first, second = shares
        found.append(Trials(seconds, int(inside.sum()), first, int((~inside).sum()), second))
    return tuple(found)


def reaching(robot: Robot, task: Mapping, plant, seconds: float) -> Shown:
    """Motions of least jerk from starts to goals of Joint-Reach, at the rate of its policies."""
    rng, t = np.random.default_rng(0), np.arange(0, 1, HOLD_S / seconds)[:, None]
    path, speed = t**3 * (10 - 15 * t + 6 * t**2), 30 * t**2 * (1 - t) ** 2 / seconds
    q, dq = [], []
    for _ in range(MOTIONS):
        start, goal = (
            np.clip(robot.home + spread * rng.normal(size=7), *robot.position_limit.T)
            for spread in (task["start_spread_rad"], task["goal_spread_rad"])
        )
        q.append(start + path * (goal - start))
        dq.append(speed * (goal - start))
    torque = free_torques(plant, robot.joints, q, dq, 1 / HOLD_S, weighs=False)
    return Shown(1 / HOLD_S, q, dq, torque, q, FREE)


def measured(task: str, whose: str, grid: Ranked, choice: tuple[float, float]) -> Measured:
    """One grid under a blend and a correlation that it had no part in."""
    cells, success = grid.cells, grid.success
    error, off = grid.predicted(*choice), grid.off_critical()
    ratio = (cells.kd / cells.kp).to_numpy()
    compliant = (cells.kp <= REGIONS.compliant_up_to_kp) & (cells.kd >= REGIONS.overdamped_from_kd)
    nearest = off == pd.Series(off).groupby(cells.kp.to_numpy()).transform("min").to_numpy()
    return Measured(
        task, whose, len(cells),
        *(float(spearman(one, success)) for one in (-error, ratio, -off, compliant.astype(float))),
        float(success.max()), float(success[error.argmin()]), float(success[ratio.argmax()]),
        float(success[nearest].mean()),
        *ruled_out(grid, error),
    )  # fmt: skip


def ruled_out(grid: Ranked, error: np.ndarray) -> tuple:
    """What `Measured` says of cells that ring, and of the others."""
    cells, success = grid.cells, grid.success
    over = []
    for kp, kd in zip(cells.kp, cells.kd, strict=True):
        steps = [step_matrices(kp, kd, m, TIMESTEP_S) for m in grid.inertia]
        f, g = (np.array(parts) for parts in zip(*steps, strict=True))
        loop = Loop(f, g[..., None], np.array([[1.0, 0.0]]), TIMESTEP_S)
        over.append(overshoot(loop, np.sqrt(kp / grid.inertia) / (2 * np.pi)).max())
    rings = np.array(over) > MOST_OVERSHOOT
    pairs = [Cell(kp, kd) for kp, kd in zip(cells.kp, cells.kd, strict=True)]
    best = int(np.where(rings, np.inf, error).argmin())
    named = to_train(best, grid.off_critical(), ~rings, pairs)
    rng = np.random.default_rng(0)
    drawn = [rng.choice(success[~rings], TRAINED, replace=False).max() for _ in range(DRAWN)]
    return (
        int(rings.sum()), float(success[rings].mean()), float(success[~rings].mean()),
        bool(rings[success.argmax()]), float(success[best]),
        float(success[named].max()), float(np.mean(drawn)),
    )  # fmt: skip


def of_ours(task: str, name: str) -> Ranked:
    """A grid of ours, its policies' successes averaged over training seeds."""
    cells = pd.read_csv(DATA / f"{name}.csv")
    cells = cells[cells.variant == "nominal"].groupby(["kp", "kd"], as_index=False).success.mean()
    return Ranked(cells, *labels_of(task))


def labels_of(task: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Inertia and residuals of positions and of displacements."""
    kept = pd.concat([pd.read_csv(DATA / f"label_residuals{end}.csv") for end in ("", "_ur5e")])
    of_task = kept[kept.task == task]
    both = [of_task[of_task.labels == kind] for kind in ("positions", "displacements")]
    return both[0].inertia_kg_m2.to_numpy(), *map(matrices, both)


def of_study(ours: Mapping[str, Ranked]) -> dict[str, Ranked]:
    """The study's own grids, nothing where there are none."""
    data = os.environ.get("T2L_STUDY_DATA")
    if not data:
        return {}
    grids = json.loads((Path(data) / "paper_results.json").read_text())["bc_success"]
    found = {}
    for name, grid in grids.items():
        if task := STUDY_NAMES.get(name):
            one = ours[task]
            cells = table(grid, "success")
            cells["success"] /= 100 if cells.success.max() > 1 else 1
            found[task] = Ranked(cells, one.inertia, one.positions, one.displacements)
    return found
