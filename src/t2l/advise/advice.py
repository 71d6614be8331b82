"""Advice on the gains of a robot's position controller: what is asked, and what is answered."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from t2l.advise.action_scale import ActionScales, action_scales
from t2l.advise.beforehand import residuals
from t2l.advise.cloning import amplifications, blended, difficulty, predicted_error
from t2l.advise.evidence import ALIKE, evidence
from t2l.advise.exclusions import (
    HOPELESS,
    KINDS,
    KNOWN_MARGIN,
    LEAST_MARGIN,
    MOST_SAG_RAD,
    RULING,
    Objection,
    objections,
)
from t2l.advise.machine import Machine, of_model
from t2l.advise.posterior import Settled, best_cell
from t2l.advise.responses import Responses, responses, settles_together
from t2l.advise.retargeted import (
    Labels,
    Replayed,
    held_steps,
    labels,
    moving_most,
    plant_of,
    replayed,
)
from t2l.advise.shown import Shown, free_torques
from t2l.advise.trainings import NEAR_CRITICAL, middle
from t2l.errors import ConfigurationError
from t2l.gains import Grid
from t2l.identify.model import Model
from t2l.names import listed

CLONING, REINFORCEMENT = WAYS = "cloning", "reinforcement"  # of learning that advice is for
POSES = 5  # numerics: inertia changes slowly from pose to pose
CHUNK = 10  # convention: commands ahead that labels are compared over, as of the measured policies
STATES = 4000  # numerics: whose neighbours are looked for
AS_GOOD = 0.05  # convention: of success, within which gains that were trained count as equal
LASTS_S = 0.2  # convention: of an error that is alike over a chunk of 10 commands at 50 Hz


@dataclass(frozen=True)
class Asked:
    """What advice is about.

    Attributes:
        model: of the machine, with its effects.
        joints: names.
        poses: (k, n) rad.
        grid: of gains, factors on `units` (n, 2).
        control_rate_hz, policy_rate_hz: of the robot's loop, and of its policy.
        compensated: whether the controller carries the weight.
        ranges: (n, 2) rad; velocity_limit, torque_limit: (n,); infinite where unknown.
        shown: what it is to do, if that is known.
        most_sag_rad: that an arm may hang low.
        ways: of `WAYS`, what it is for.
        known: whether the model has all that was measured of the machine, but for noise.
        threads: of the replay.
    """

    model: Model
    joints: tuple[str, ...]
    poses: np.ndarray
    grid: Grid
    units: np.ndarray
    control_rate_hz: float
    policy_rate_hz: float
    compensated: bool
    ranges: np.ndarray
    velocity_limit: np.ndarray
    torque_limit: np.ndarray
    shown: Shown | None = None
    most_sag_rad: float = MOST_SAG_RAD
    ways: tuple[str, ...] = WAYS
    known: bool = False
    threads: int = 1

    @cached_property
    def gains(self) -> tuple[np.ndarray, np.ndarray]:
        """Kp and Kd (cell, n), by Kd upward, then by Kp."""
        cells = np.array([[cell.kp, cell.kd] for cell in self.grid.cells])
        return cells[:, :1] * self.units[:, 0], cells[:, 1:] * self.units[:, 1]

    @property
    def least_margin(self) -> float:
        """Times that gains may rise before the loop no longer settles, at least."""
        return KNOWN_MARGIN if self.known else LEAST_MARGIN

    def machine(self) -> Machine:
        """The machine at the poses."""
        return of_model(
            self.model, self.joints, self.poses, self.control_rate_hz, self.compensated,
            self.torque_limit,
        )  # fmt: skip


@dataclass(frozen=True)
class Cloning:
    """What behaviour cloning makes of every pair of gains.

    Attributes:
        labels: of the demonstrations; replay: of some of them.
        amplification: (cell, n) of independent errors; lasting: of errors alike for `LASTS_S`.
        difficulty: (cell, n) rad² of labels.
        error: (cell,) rad, predicted.
        by_joint: (cell, n) rad² of which that is the root of the mean.
    """

    labels: Labels
    replay: Replayed
    amplification: np.ndarray
    lasting: np.ndarray
    difficulty: np.ndarray

    @cached_property
    def by_joint(self) -> np.ndarray:
        return self.amplification * self.difficulty

    @cached_property
    def error(self) -> np.ndarray:
        return predicted_error(self.amplification, self.difficulty)


@dataclass(frozen=True)
class Advice:
    """What is answered.

    Attributes:
        responses: of the loop; cloning, scales: None where nothing was shown.
        objections: to pairs of gains on joints, each with its reason.
        off_critical: (cell,) |ln ζ| of the joint of median inertia.
        score: (cell,) the smaller the better: predicted error in rad, or `off_critical` where
            nothing was shown.
        best: the cell that is advised.
        own: joints that rule `best` out and have gains of a cell of their own.
        cells: (n,) the cell of each joint.
        settled: what trainings said, if there were some.
    """

    asked: Asked
    machine: Machine
    responses: Responses
    cloning: Cloning | None
    scales: ActionScales | None
    objections: list[Objection]
    off_critical: np.ndarray
    score: np.ndarray
    best: int
    cells: np.ndarray
    settled: Settled | None = None

    @cached_property
    def allowed(self) -> np.ndarray:
        """(cell, n) bool, what no joint rules out."""
        return allowed(self.ruling, self.responses.overshoot.shape)

    @cached_property
    def ruling(self) -> list[Objection]:
        """Objections that rule gains out; without demonstrations all do, as nothing weighs them."""
        return ruling(self.objections, self.cloning is not None)

    @cached_property
    def costing(self) -> list[Objection]:
        """The others, which the predicted error weighs."""
        return [one for one in self.objections if one not in self.ruling]

    @cached_property
    def hopeless(self) -> np.ndarray:
        """(cell,) bool, whose predicted error is `HOPELESS` times that of `best` and more."""
        if self.cloning is None:
            return np.zeros(len(self.score), bool)
        return self.score >= HOPELESS * self.score[self.best]

    @property
    def ruled_out(self) -> np.ndarray:
        """(cell,) bool, by a joint or for being hopeless."""
        return ~self.allowed.all(axis=1) | self.hopeless

    @property
    def gains(self) -> np.ndarray:
        """(n, 2) N·m/rad and N·m·s/rad, advised."""
        joints = np.arange(len(self.cells))
        return np.stack([gain[self.cells, joints] for gain in self.asked.gains], axis=1)

    @property
    def own(self) -> tuple[int, ...]:
        """Joints whose gains are of another cell than `best`."""
        return tuple(np.flatnonzero(self.cells != self.best).tolist())

    @cached_property
    def as_good(self) -> np.ndarray:
        """(cell,) bool: allowed as `best` is, and not to be told from it by the score."""
        left = self.left
        if self.settled is not None:
            mean = self.settled.believed.mean
            return left & (mean >= mean[self.best] - AS_GOOD)
        if self.cloning is None:
            return left & (self.score <= self.score[left].min() + NEAR_CRITICAL)
        return left & (self.score <= ALIKE * self.score[self.best])

    @cached_property
    def left(self) -> np.ndarray:
        """(cell,) bool, which cells the fewest joints rule out, if they are not hopeless."""
        return _left(self.allowed) & ~self.hopeless

    def chance(self) -> np.ndarray:
        """(cell,) share of measured pairs in which the like of `best` was better than a cell's."""
        factor = self.score / self.score[self.best]
        return np.array([evidence().right(max(f, 1.0)).right for f in factor])


def settled(advice: Advice, found: Settled) -> Advice:
    """The same after trainings, with the gains that are believed to be best."""
    best = best_cell(found.believed, advice.left)
    by_joint = advice.cloning.by_joint if advice.cloning else advice.score[:, None]
    return replace(
        advice, best=best, cells=own_cells(best, advice.allowed, by_joint), settled=found
    )


def advised(
    asked: Asked, progress: Callable[[str, float], None] = lambda what, part: None
) -> Advice:
    """Compute all of it.

    Raises:
        ConfigurationError: no gains of the grid hold a joint; it says which, and why.
    """
    progress("the loop of every joint", 0.0)
    machine = asked.machine()
    found = responses(machine, *asked.gains)
    cloning = scales = None
    if asked.shown is not None and CLONING in asked.ways:
        cloning = _cloning(asked, machine, asked.shown, progress)
    if asked.shown is not None and REINFORCEMENT in asked.ways:
        steps = held_steps(asked.shown.rate_hz, asked.policy_rate_hz)
        limits = machine.friction, machine.torque_limit
        scales = action_scales(asked.shown, *machine.real(*asked.gains), *limits, steps)
    told = objections(
        machine, *asked.gains, found, cloning and cloning.labels, cloning and cloning.replay,
        asked.most_sag_rad, asked.least_margin,
    )  # fmt: skip
    against = ruling(told, cloning is not None)
    may = allowed(against, found.overshoot.shape)
    for joint in np.flatnonzero(~may.any(axis=0)):
        _refuse(asked, against, int(joint))
    off, left = _off_critical(machine, *asked.gains), _left(may)
    if cloning is None:
        score, best = off, middle(off, left, asked.gains[0][:, 0])
    else:
        score, best = cloning.error, least(cloning.error, left)
    # what is best for each joint alone, or else what is farthest from unstable
    for by_joint in (score[:, None] if cloning is None else cloning.by_joint, -found.margin):
        cells = own_cells(best, may, by_joint)
        advice = Advice(asked, machine, found, cloning, scales, told, off, score, best, cells)
        gains = (gain[None] for gain in advice.gains.T)
        if not advice.own or settles_together(machine, *gains)[0]:
            return advice
    names = listed([asked.joints[j] for j in advice.own])
    raise ConfigurationError(
        f"--kp, --kd: found no pair of gains that holds every joint, and with gains of their own "
        f"for {names} the joints do not settle together, though each does alone; allowed: a finer "
        "grid, with lower gains"
    )


def ruling(told: list[Objection], weighed: bool) -> list[Objection]:
    """Those that rule gains out.

    Args:
        weighed: whether a predicted error weighs the others.
    """
    return [one for one in told if one.kind in (RULING if weighed else KINDS)]


def allowed(told: list[Objection], shape: tuple[int, int]) -> np.ndarray:
    """(cell, n) bool, what is left."""
    may = np.ones(shape, bool)
    for one in told:
        may[one.cell, one.joint] = False
    return may


def least(score: np.ndarray, left: np.ndarray) -> int:
    """The cell of the least score (cell,) of those that are left (cell,)."""
    return int(np.where(left, score, np.inf).argmin())


def own_cells(best: int, may: np.ndarray, by_joint: np.ndarray) -> np.ndarray:
    """(n,) the cell of each joint: `best`, or where it rules that out, the best of its own.

    Args:
        by_joint: a score of each joint, that broadcasts to (cell, n).
    """
    own = np.where(may, by_joint, np.inf).argmin(axis=0)
    return np.where(may[best], best, own)


def _left(may: np.ndarray) -> np.ndarray:
    """(cell,) bool, which cells the fewest joints rule out."""
    ruled = (~may).sum(axis=1)
    return ruled == ruled.min()


def _cloning(asked: Asked, machine: Machine, shown: Shown, progress) -> Cloning:
    kp, kd = asked.gains
    real = machine.real(kp, kd)
    steps = held_steps(shown.rate_hz, asked.policy_rate_hz)
    progress("labels of every pair of gains", 0.1)
    told = labels(shown, *real, steps, asked.ranges, asked.velocity_limit)
    states = [one[::steps] for one in shown.state]
    recorded = [
        np.stack(parts, axis=-1)[::steps]
        for parts in zip(shown.q, shown.torque, shown.dq, strict=True)
    ]
    every = max(1, sum(map(len, states)) // STATES)
    progress("how alike commands of alike states are", 0.2)
    hard = blended(
        *(
            difficulty(residuals(states, recorded, CHUNK, every, displacements), *real)
            for displacements in (False, True)
        )
    )
    progress("what errors of commands become", 0.4)
    # e' = ρ e loses all but 1/e over the time that an error lasts
    alike = float(np.exp(-1 / (LASTS_S * asked.policy_rate_hz)))
    amplification, lasting = amplifications(machine, kp, kd, asked.policy_rate_hz, (0.0, alike))
    progress("replaying demonstrations in the machine's loop", 0.5)
    plant = plant_of(asked.model, asked.joints)
    motions = moving_most(
        shown,
        lambda q, dq: free_torques(
            plant, asked.joints, q, dq, shown.rate_hz, not asked.compensated
        ),
    )
    replay = replayed(
        asked.model, asked.joints, motions, shown.rate_hz, kp, kd, asked.policy_rate_hz,
        asked.control_rate_hz, asked.compensated, machine.torque_limit,
        machine.gain_factor.T, asked.threads,
        lambda part: progress("replaying demonstrations in the machine's loop", 0.5 + 0.4 * part),
    )  # fmt: skip
    return Cloning(told, replay, amplification, lasting, hard)


def _off_critical(machine: Machine, kp: np.ndarray, kd: np.ndarray) -> np.ndarray:
    """(cell,) |ln ζ| of the joint of median inertia."""
    inertia = machine.inertia.mean(axis=0)
    j = int(np.argsort(inertia)[len(inertia) // 2])
    kp, kd = (machine.gain_factor[j, i] * gain[:, j] for i, gain in enumerate((kp, kd)))
    return np.abs(np.log(kd / (2 * np.sqrt(kp * inertia[j]))))


def _refuse(asked: Asked, told: list[Objection], joint: int) -> None:
    own = [one for one in told if one.joint == joint]
    nearest = min(own, key=lambda one: (one.by, one.cell))
    kp, kd = asked.grid.kp, asked.grid.kd
    raise ConfigurationError(
        f"--kp, --kd: found no gains among Kp {kp[0]:g} to {kp[-1]:g} and Kd {kd[0]:g} to "
        f"{kd[-1]:g} that hold {asked.joints[joint]}; the nearest: {nearest.why}; allowed: a grid "
        "with gains that do"
    )
