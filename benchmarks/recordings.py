"""Recordings that benchmarks share, made once and kept in results/bench.

Delete a folder there to make it anew. The environment variable T2L_FR3_RECORDINGS names a folder
to use in place of the made FR3 grid.
"""

import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.hidden_effects.cases import ROBOTS
from benchmarks.hidden_effects.commands import COMMANDS
from benchmarks.hidden_effects.effects import (
    Armature,
    Backlash,
    CoulombFriction,
    HiddenEffect,
    ViscousFriction,
)
from benchmarks.hidden_effects.generator import record, write
from benchmarks.scene import ROOT
from t2l.artefacts import whole
from t2l.effects.registry import builtin
from t2l.effects.term import Layout, Term
from t2l.gains import Cell
from t2l.identify.prediction import Predictor, Request
from t2l.recordings.log import read_recordings, write_recording
from t2l.recordings.recording import Recording
from t2l.robots import make_robot

FOLDER = ROOT / "results/bench"

KP, KD = (16, 32, 64, 128, 160, 256, 512), (1, 2, 4, 8, 12, 16, 24)
GRID_S, COMMAND_HZ, SAMPLE_HZ, RESOLUTION_RAD = 4.0, 50, 25, 1e-3
HIDDEN_IN_GRID = {"coulomb_friction": {"torque": 0.5}, "viscous_friction": {"damping": 1.0}}

SINGLE_S = 10.0
SINGLE_HIDDEN = {
    ("friction", "two_joint_arm"): CoulombFriction({"shoulder": 0.15, "elbow": 0.06}),
    ("friction", "fr3"): CoulombFriction(0.6),
    ("play", "two_joint_arm"): Backlash({"shoulder": 0.05, "elbow": 0.05}),
    ("play", "fr3"): Backlash({"fr3_joint1": 0.02}),
}

THREE_S = 4.0
# beyond the MJCF's, by MuJoCo's name of it
THREE_HIDDEN = {
    "frictionloss": {"shoulder": 0.15, "elbow": 0.06},
    "damping": {"shoulder": 0.2, "elbow": 0.08},
    "armature": {"shoulder": 0.01, "elbow": 0.006},
}
# which of the robot's gain settings, what is commanded, share of the amplitude
THREE_MOTIONS = {
    "train/compliant": (0, "multisine", 1.0),
    "train/medium": (1, "triangle", 0.8),
    "train/stiff": (2, "chirp", 0.8),
    "holdout/compliant": (0, "smooth_steps", 0.8),
    "holdout/stiff": (2, "multisine", 0.9),
}


def fr3_grid() -> list[Recording]:
    """Recordings of an FR3 at 49 gains, those given or those made."""
    given = os.environ.get("T2L_FR3_RECORDINGS")
    return read_recordings(Path(given).resolve() if given else _once("fr3_grid", _make_grid))


def spread_cells(
    recordings: Sequence[Recording], count: int
) -> tuple[list[Recording], list[Recording]]:
    """All but those of `count` gain cells, and those, the cells spread over the grid."""
    cells = sorted({(*r.kp, *r.kd) for r in recordings})
    at = np.linspace(0, len(cells) - 1, count + 2)[1:-1].round().astype(int)
    chosen = {cells[i] for i in at}
    rest = [r for r in recordings if (*r.kp, *r.kd) not in chosen]
    return rest, [r for r in recordings if (*r.kp, *r.kd) in chosen]


def single(hidden: str, robot: str) -> Path:
    """Folder with one recording of 10 s, in which an effect of `SINGLE_HIDDEN` is hidden."""
    effects = (SINGLE_HIDDEN[hidden, robot],)
    return _once(
        f"single_{hidden}_{robot}",
        lambda folder: _record(
            folder / "multisine", robot, (1, "multisine", 1.0), SINGLE_S, effects, 0
        ),
    )


def three_parameters() -> tuple[list[Recording], list[Recording]]:
    """To fit and to hold out: the two-joint arm with `THREE_HIDDEN`."""

    hidden = (
        CoulombFriction(THREE_HIDDEN["frictionloss"]),
        ViscousFriction(THREE_HIDDEN["damping"]),
        Armature(THREE_HIDDEN["armature"]),
    )

    def make(folder: Path) -> None:
        for seed, (name, motion) in enumerate(THREE_MOTIONS.items()):
            _record(folder / name, "two_joint_arm", motion, THREE_S, hidden, seed)

    folder = _once("three_parameters", make)
    return read_recordings(folder / "train"), read_recordings(folder / "holdout")


def _once(name: str, make: Callable[[Path], None]) -> Path:
    folder = FOLDER / name
    if not folder.exists():
        with whole(folder) as draft:
            make(draft)
    return folder


def _make_grid(folder: Path) -> None:
    """Predicted by t2l itself with more friction, at rest first, rounded as the log rounds."""
    row = np.arange(int(GRID_S * COMMAND_HZ))
    wave = 0.15 * np.sin(np.pi * row / 50)
    robot = make_robot("fr3")
    q_des = robot.home + wave[:, None]
    q = np.where((row % (COMMAND_HZ // SAMPLE_HZ) == 0)[:, None], robot.home, np.nan)
    n = len(robot.joints)
    blank = [
        Recording(
            name=cell.name,
            path=None,
            robot=robot.name,
            joints=robot.joints,
            kp=np.full(n, cell.kp),
            kd=np.full(n, cell.kd),
            command_rate_hz=COMMAND_HZ,
            control_rate_hz=1000,
            gravity_compensation=True,
            time=row / COMMAND_HZ,
            q_des=q_des,
            q=q,
        )
        for cell in (Cell(kp=float(kp), kd=float(kd)) for kd in KD for kp in KP)
    ]
    predictor = Predictor("fr3", blank)
    layout = Layout([Term(builtin()[name], tuple(range(n))) for name in HIDDEN_IN_GRID])
    u = layout.encode(HIDDEN_IN_GRID)
    predicted = predictor.predict([Request(layout, u[None])])[0][0]
    samples = predictor.samples
    for i, recording in enumerate(blank):
        at = samples.recording == i
        q = np.full_like(recording.q, np.nan)
        q[samples.row[at], samples.joint[at]] = (
            np.round(predicted[at] / RESOLUTION_RAD) * RESOLUTION_RAD
        )
        write_recording(replace(recording, q=q), folder / recording.name)


def _record(
    path: Path,
    name: str,
    motion: tuple[int, str, float],
    duration_s: float,
    hidden: tuple[HiddenEffect, ...],
    seed: int,
) -> None:
    robot = ROBOTS[name]
    setup, (gain, kind, share) = robot.setup, motion
    kp, kd = setup.gains[gain]
    of_motion, of_noise = np.random.default_rng(seed).spawn(2)
    move = COMMANDS[kind](of_motion, share * np.array(robot.amplitude), duration_s)
    logged = {
        "command_rate_hz": setup.command_rate_hz,
        "control_rate_hz": setup.control_rate_hz,
        "gravity_compensation": setup.gravity_compensation,
    }
    frame = record(
        robot.mjcf,
        robot.joints,
        kp,
        kd,
        lambda t: np.array(robot.home) + move(t),
        duration_s=duration_s,
        physics_rate_hz=setup.physics_rate_hz,
        hidden=hidden,
        encoder_resolution_rad=setup.encoder_resolution_rad,
        encoder_noise_rad=setup.encoder_noise_rad,
        sample_rate_hz=setup.sample_rate_hz,
        rng=of_noise,
        **logged,
    )
    mjcf = "fr3" if name == "fr3" else robot.mjcf
    write(frame, path, robot=mjcf, joints=robot.joints, kp=kp, kd=kd, **logged)
