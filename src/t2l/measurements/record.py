"""Recording from an FR3 driven by aiofranka, real or simulated, with the same calls.

For each setting of gains the arm goes to the start, comes to rest under these gains, and follows
the commands of the plan. aiofranka's loop logs every cycle; a row is kept for each command, at the
cycle that first used it, so that the log says when a command acted and not when it was sent.
"""

import contextlib
import time
from collections.abc import Callable, Iterator
from importlib.metadata import version
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from t2l.errors import RecordingError
from t2l.measurements.excitation import SMOOTH_STEP_PEAK_VELOCITY, smooth_step
from t2l.measurements.limits import check_state
from t2l.measurements.log import write_recording
from t2l.measurements.plan import CONTROL_RATE_HZ, SIMULATION, Plan, Setting, check_free
from t2l.measurements.recording import Recording

# to move about and to brake: aiofranka's stiffness, and damping near critical at every joint
APPROACH_KP, APPROACH_KD = 80.0, 16.0
APPROACH_VELOCITY = 0.4  # rad/s

# to come to rest at the start under the gains of the setting
SETTLE_S = 1.0
# to come to rest when a motion is broken off
BRAKE_S = 0.5

FIELDS = ["time", "q", "dq", "tau", "q_desired"]
TAU = "tau is the torque that was sent, on top of the robot's gravity compensation"


def record(plan: Plan, folder: Path | str, report: Callable[[str], None] = print) -> list[Path]:
    """Record every setting of a plan; each recording is written when it is complete.

    Whatever ends it, an error or Ctrl-C, the arm is first held where it is, then released.

    Args:
        plan: a checked plan.
        folder: for the recordings.
        report: takes a line for each recording.

    Returns:
        The paths of the tables.

    Raises:
        RecordingError: a recording is there already, the robot cannot be reached, its loop
            stopped, or it left its limits.
    """
    folder = Path(folder)
    check_free(plan, folder)
    paths = []
    with _arm(plan) as arm:
        for setting in plan.settings:
            recording = _record_one(arm, plan, setting)
            paths.append(write_recording(recording, folder / setting.name))
            report(f"{paths[-1]}: {_summary(recording, plan)}")
    return paths


def _summary(recording: Recording, plan: Plan) -> str:
    lag = np.nanmax(np.abs(recording.q_des - recording.q))
    text = f"{recording.duration_s:.1f} s, up to {lag:.3f} rad behind"
    used = {row.tobytes() for row in recording.q_des}
    skipped = sum(row.tobytes() not in used for row in plan.q_des)
    if skipped:
        text += f"; the loop was too late for {skipped} of {len(plan.q_des)} commands"
    return text


@contextlib.contextmanager
def _arm(plan: Plan) -> Iterator[Any]:
    """A started aiofranka Controller, stopped again however the block ends."""
    # slow to import, and only needed here
    import aiofranka

    try:
        with _no_viewer():
            robot = aiofranka.Robot(None if plan.address == SIMULATION else plan.address)
    # libfranka's errors have no common base but Exception
    except Exception as error:
        reason = " ".join(str(error).split())
        raise RecordingError(
            plan.path,
            "key address",
            f"{plan.address}, which cannot be reached ({reason})",
            f"{SIMULATION}, or the address of an FR3 with FCI active (aiofranka unlock)",
        ) from None
    controller = aiofranka.Controller(robot)
    try:
        controller.start()
        yield controller
    except RuntimeError as error:
        raise RecordingError(
            plan.path, "the robot", str(error), "a run without errors of the robot"
        ) from error
    finally:
        try:
            _brake(controller)
        finally:
            robot.close()


@contextlib.contextmanager
def _no_viewer() -> Iterator[None]:
    """Let aiofranka's simulation do without the window that it opens unasked."""
    import mujoco.viewer

    class NoViewer:
        def sync(self) -> None: ...

        def close(self) -> None: ...

    launch = mujoco.viewer.launch_passive
    mujoco.viewer.launch_passive = lambda *_, **__: NoViewer()
    try:
        yield
    finally:
        mujoco.viewer.launch_passive = launch


def _brake(controller: Any) -> None:
    """Hold the arm where it is until it rests; a loop that has stopped needs none of it."""
    if not controller.running:
        return
    with contextlib.suppress(RuntimeError):
        _take_gains(controller, np.full(7, APPROACH_KP), np.full(7, APPROACH_KD))
        time.sleep(BRAKE_S)


def _take_gains(controller: Any, kp: np.ndarray, kd: np.ndarray) -> np.ndarray:
    """Change gains without a jump: the target becomes the pose, which is returned."""
    controller.switch("impedance")
    controller.kp, controller.kd = kp, kd
    return np.array(controller.initial_qpos)


def _record_one(controller: Any, plan: Plan, setting: Setting) -> Recording:
    start = plan.q_des[0]
    here = _take_gains(controller, np.full(7, APPROACH_KP), np.full(7, APPROACH_KD))
    distance = np.abs(start - here).max()
    duration = max(1.0, SMOOTH_STEP_PEAK_VELOCITY * distance / APPROACH_VELOCITY)
    _follow(controller, plan, _line(here, start, duration, plan), f"{setting.name}, approach")
    here = _take_gains(controller, setting.kp, setting.kd)
    settle = _line(here, start, SETTLE_S, plan)
    hold = np.repeat(start[None], round(SETTLE_S * plan.command_rate_hz), axis=0)
    _follow(controller, plan, np.concatenate([settle, hold]), f"{setting.name}, settling")
    # the loop must never wait for its buffer to be emptied
    with controller.record(FIELDS, seconds=plan.duration_s + 60.0) as cycles:
        _follow(controller, plan, plan.q_des, setting.name)
    if cycles.dropped:
        raise RecordingError(
            plan.path, setting.name, f"{cycles.dropped} cycles not logged", "none; record it again"
        )
    return _as_recording(cycles.data(), plan, setting)


def _line(start: np.ndarray, end: np.ndarray, duration_s: float, plan: Plan) -> np.ndarray:
    """Commands from one pose to another, (n, njoint)."""
    n = max(2, round(duration_s * plan.command_rate_hz))
    return start + smooth_step(np.arange(1, n + 1) / n)[:, None] * (end - start)


def _follow(controller: Any, plan: Plan, q_des: np.ndarray, what: str) -> None:
    """Send commands at their rate, and watch the arm.

    A command is never sent earlier than a period after the one before: what a stalled computer
    did not send in time comes late, where catching up would make the arm jump.
    """
    period = 1 / plan.command_rate_hz
    due = time.perf_counter()
    for row, command in enumerate(q_des):
        controller.q_desired = command
        due = max(due + period, time.perf_counter() + period / 2)
        time.sleep(max(0.0, due - time.perf_counter()))
        state = controller.robot.state
        where = f"{what}, {row * period:.2f} s"
        check_state(state["qpos"], state["qvel"], plan.limits, plan.path, where)


def _as_recording(cycles: dict[str, np.ndarray], plan: Plan, setting: Setting) -> Recording:
    rows = _rows_of_commands(cycles["q_desired"], round(CONTROL_RATE_HZ / plan.command_rate_hz))
    clock = cycles["time"][rows]
    return Recording(
        name=setting.name,
        path=None,
        robot="fr3",
        joints=plan.limits.joints,
        kp=setting.kp,
        kd=setting.kd,
        command_rate_hz=plan.command_rate_hz,
        control_rate_hz=float(CONTROL_RATE_HZ),
        gravity_compensation=True,
        # cycles are counted in ms; more digits are rounding
        time=np.round(clock - clock[0], 6),
        q_des=cycles["q_desired"][rows],
        q=cycles["q"][rows],
        dq=cycles["dq"][rows],
        tau=cycles["tau"][rows],
        notes=f"{plan.notes}; {TAU}; aiofranka {version('aiofranka')}, {plan.address}",
    )


def _rows_of_commands(q_des: np.ndarray, period: int) -> np.ndarray:
    """Cycles that first used a command, (m,), and others between where one held for long.

    Args:
        q_des: rad, (n, njoint), that each cycle used.
        period: cycles that a command is to hold.
    """
    changes = np.flatnonzero((np.diff(q_des, axis=0) != 0).any(axis=1)) + 1
    edges = [0, *changes.tolist(), len(q_des)]
    rows: list[int] = []
    for begin, end in pairwise(edges):
        # a row too close to the next change would say nothing new
        rows += range(begin, max(begin + 1, end - period // 2), period)
    return np.array(rows)
