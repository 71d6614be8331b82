"""Pictures of scripts that solve a task or fail: `python -m tests.tasks.pictures FOLDER`."""

import contextlib
import sys
from pathlib import Path

import numpy as np

from t2l.environment.environment import Environment
from t2l.figures.frames import filmstrips
from t2l.plotting.style import write
from t2l.tasks import Rewarded
from tests.defaults import shipped
from tests.tasks.scripted import PERIOD_S, lead


@contextlib.contextmanager
def watched():
    """Positions (nq,) of the first robot before each step of any environment."""
    plain, seen = Environment.advance, []

    def advance(self, action):
        seen.append(self.simulator.batch.qpos[0].copy())
        return plain(self, action)

    Environment.advance = advance
    try:
        yield seen
    finally:
        Environment.advance = plain


def reaching(
    task: Rewarded, beside: float, shake_rad: float
) -> tuple[np.ndarray, list[np.ndarray]]:
    """Times in s and positions of an arm that is led to its goal."""
    starts, goals, targets = (
        sample(np.random.default_rng(3), 1)
        for sample in (task.sample_starts, task.sample_goals, task.sample_joint_goals)
    )
    with watched() as seen:
        lead(task, starts, goals, targets + beside)
    return PERIOD_S * np.arange(len(seen)), seen


def main(folder: Path) -> None:
    """Draw the tasks of a robot alone."""
    task = shipped("end_effector_reach", goal_spread_rad=0.8)
    strips = {"at its goal": reaching(task, 0.0), "beside it": reaching(task, 0.3)}
    figure = filmstrips(task, strips, 6, f"EE-Reach: {task.instruction}")
    write(figure, [folder / "end_effector_reach_frames.png"], dpi=110)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
