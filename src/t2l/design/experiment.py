"""An experiment: which motions to record, so that effects can be told apart."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from t2l.design.d_optimal import exchange, log_det
from t2l.design.expected import Identifiability
from t2l.design.identifiability import identifiability
from t2l.design.library import Candidate, library, recording, shortest_s
from t2l.design.safety import WORKSPACE_MARGIN_M, Safe, leaves, tool_places, within_limits
from t2l.design.sensitivity import Sensitivity
from t2l.effects.effect import Effect
from t2l.errors import ConfigurationError, RecordingError
from t2l.hardware.excitation_kinds import LONGEST_S
from t2l.hardware.guard import Workspace
from t2l.hardware.limits import check_loop
from t2l.hardware.motion import Motion
from t2l.hardware.nominal import SampledLoop
from t2l.hardware.plan import Setup
from t2l.hardware.plan_file import MOST_GAINS
from t2l.identify.loop_stability import check_settles
from t2l.identify.model import Model
from t2l.recordings.splits import LEAST_TO_HOLD_OUT_WHOLE

FEWEST = LEAST_TO_HOLD_OUT_WHOLE  # motions: a diagnosis holds some of them out as a whole
RANDOM = 100  # statistics: choices that the chosen one is compared with
SEED = 0  # statistics: of those choices

Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class Wanted:
    """What an experiment is to be.

    Attributes:
        effects: that are to be told apart.
        total_s: of all motions together; `motion_s` of each.
        most_rad: largest offset from the start.
        noise_rad: standard deviation of a measured position.
        workspace: for the tool, in the frame of the robot's base.
    """

    effects: Sequence[Effect]
    total_s: float
    motion_s: float
    most_rad: float
    noise_rad: float
    workspace: Workspace | None = None


@dataclass(frozen=True)
class Experiment:
    """The motions that were chosen of a library, and what they will tell.

    Attributes:
        chosen: in order of choice.
        peaks: the largest part of what is safe that each uses in simulation.
        considered, unsafe: how many motions there were, and how many no size makes safe.
        log_det: of the chosen ones; `best_single` of the best motion alone; `random` the mean of
            random choices of as many.
    """

    chosen: list[Candidate]
    peaks: list[float]
    considered: int
    unsafe: int
    log_det: float
    best_single: float
    random: float
    told: Identifiability


def design(
    setup: Setup,
    model: Model,
    wanted: Wanted,
    progress: Progress = lambda what, fraction: None,
) -> Experiment:
    """The D-optimal choice of safe motions.

    Raises:
        ConfigurationError: as of `check_wanted`; the model's loop chatters, no motion is safe, or
            no effect can be
            simulated.
    """
    check_wanted(setup, wanted)
    progress("keeping motions within limits", 0.0)
    every = library(setup, wanted.motion_s, wanted.most_rad)
    of_gains = {(*c.kp, *c.kd): recording(setup, c.motion(setup)) for c in every}
    check_settles(model, list(of_gains.values()))
    safe = within_limits(setup, model, every, wanted.workspace)
    if not safe.candidates:
        raise ConfigurationError(
            f"{setup.path}: found no motion around start_rad that keeps a margin to the limits of "
            f"{setup.robot.name}; allowed: a start away from them, softer gains or a larger "
            "workspace"
        )
    progress(f"what {len(safe.candidates)} motions tell of {len(wanted.effects)} effects", 0.2)
    recordings = [recording(setup, c.motion(setup)) for c in safe.candidates]
    together = [
        one for one, c in zip(recordings, safe.candidates, strict=True)
        if c.moved == "all" and c.amplitude_rad.any()
    ]  # fmt: skip
    shapes = len({c.shape for c in safe.candidates})
    reference = (together or recordings)[:shapes]
    sensitivity = Sensitivity(model, wanted.effects, reference, wanted.noise_rad)
    if not sensitivity.presences:
        raise ConfigurationError(
            f"{setup.path}: the simulation runs away with every effect; allowed: gains that the "
            "robot can be held by"
        )
    information = sensitivity.information(recordings)
    progress("choosing", 0.9)
    chosen = exchange(information, motion_count(setup, wanted))
    told = identifiability(sensitivity, [recordings[i] for i in chosen])
    return _experiment(safe, len(every), information, chosen, told)


def check_wanted(setup: Setup, wanted: Wanted) -> None:
    """Find what cannot come to an experiment, before anything is simulated.

    Raises:
        RecordingError: gains are missing, or make a joint ring.
        ConfigurationError: the times do not go together, or the tool starts outside of its box.
    """
    motion_count(setup, wanted)
    loop = SampledLoop(setup.robot, setup.features, setup.start)
    for name, (kp, kd) in setup.gains().items():
        held = Motion(name, setup.start[None], setup.command_rate_hz, kp, kd)
        check_loop(setup.robot, loop, held, setup.path)
    if wanted.workspace and leaves(wanted.workspace, setup, setup.start[None]):
        x, y, z = tool_places(setup, setup.start[None])[0]
        raise ConfigurationError(
            f"--workspace: found a box that the tool leaves at the start, x {x:.3f}, y {y:.3f}, "
            f"z {z:.3f} m; allowed: one with that at least {WORKSPACE_MARGIN_M} m inside"
        )


def motion_count(setup: Setup, wanted: Wanted) -> int:
    """How many motions fit into the time: at least `FEWEST`, and no more than a plan may have.

    Raises:
        RecordingError: commands are too rare for any motion.
        ConfigurationError: a motion is too short for its slowest sine, or too few or many fit.
    """
    rate, shortest = setup.command_rate_hz, shortest_s(setup.command_rate_hz)
    if shortest > LONGEST_S:
        raise RecordingError(
            setup.path, "key command_rate_hz", f"{rate:g}",
            f"from {rate * shortest / LONGEST_S:.2g} up, for motions of {LONGEST_S} s at most",
        )  # fmt: skip
    if wanted.motion_s < shortest:
        raise ConfigurationError(
            f"--motion-s: found {wanted.motion_s:g} with command_rate_hz {rate:g}; allowed: "
            f"{shortest:g} to {LONGEST_S}"
        )
    # a whole number may be a rounding short of itself
    count = int(wanted.total_s / wanted.motion_s + 1e-9)
    if not FEWEST <= count <= MOST_GAINS:
        least, most = FEWEST * wanted.motion_s, MOST_GAINS * wanted.motion_s
        raise ConfigurationError(
            f"--total-s: found {wanted.total_s:g} with --motion-s {wanted.motion_s:g}; allowed: "
            f"{least:g} to {most:g}, for {FEWEST} to {MOST_GAINS} motions of that length"
        )
    return count


def _experiment(
    safe: Safe,
    considered: int,
    information: np.ndarray,
    chosen: list[int],
    told: Identifiability,
) -> Experiment:
    rng = np.random.default_rng(SEED)
    random = [
        log_det(information[rng.choice(len(information), len(chosen), replace=False)].sum(axis=0))
        for _ in range(RANDOM)
    ]
    return Experiment(
        chosen=[safe.candidates[i] for i in chosen],
        peaks=[float(safe.peaks[i]) for i in chosen],
        considered=considered,
        unsafe=considered - len(safe.candidates),
        log_det=log_det(information[chosen].sum(axis=0)),
        best_single=max(log_det(one) for one in information),
        random=float(np.mean(random)),
        told=told,
    )
