"""What is tried before the first job: whether a scene holds, its expert can, its cameras see.

All of it would fail in a job too, but later, when others have been running for long.
"""

from collections.abc import Iterable, Mapping, Sequence
from math import ceil, log
from typing import Any

import mujoco
import numpy as np

from t2l.demos.demonstration import Demonstration
from t2l.demos.expert import ATTEMPTS_AT_ONCE, attempt
from t2l.demos.pictures import render
from t2l.errors import CameraError, ConfigurationError, ExpertError, RendererError
from t2l.sim.batch import TIMESTEP_S
from t2l.tasks import Demonstrated, make_task
from t2l.tasks.cameras import Cameras

# of bodies at a start: beyond what touching leaves, of everything that ships 1e-16 m
DEEPEST_M = 0.001
STARTS = 16
# an expert that is good enough fails in all attempts so seldom
UNLUCKY = 1e-3
FEWEST_ATTEMPTS = 8
# pictures of the demonstration, spread over it: a view of nothing shows in any, a still one in all
LOOKS = 6


def rehearse(
    name: str,
    parameters: Mapping[str, Any],
    count: int,
    max_attempts: int,
    rng: np.random.Generator,
    observations: Iterable[Mapping[str, Any]] = (),
    threads: int = 1,
) -> None:
    """Try a task once.

    Args:
        name: of its file in config/tasks/, for messages.
        parameters: what the file holds, checked.
        count, max_attempts: of the demonstrations that are wanted.
        observations: what policies are to see: sections with `cameras` and `size_px`.

    Raises:
        ConfigurationError: MuJoCo does not compile the scene, bodies begin inside each other, or a
            policy has less time than the expert takes.
        ExpertError: the expert fails ever again.
        CameraError: a camera sees nothing. Where nothing can render, none is tried.
    """
    where = f"config/tasks/{name}.yaml"
    task = make_task(parameters)
    _compiled(where, task, visual=False)
    _check_starts(where, task, task.sample_starts(rng, STARTS))
    shown = _demonstration(where, task, _attempts(count, max_attempts), rng, threads)
    _check_horizon(where, task, shown)
    for observation in observations:
        model = _compiled(where, task, visual=True)
        try:
            with Cameras(model, **observation) as cameras:
                _look(where, cameras, shown)
        except RendererError:
            return


def _compiled(where: str, task: Demonstrated, visual: bool) -> mujoco.MjModel:
    try:
        return task.spec(visual=True).compile() if visual else task.model
    except (ValueError, mujoco.FatalError) as error:
        found = " ".join(str(error).split())
        raise ConfigurationError(
            f"{where}: the scene: found what MuJoCo does not compile ({found}); allowed: a model"
        ) from None


def _check_starts(where: str, task: Demonstrated, starts: Sequence[np.ndarray]) -> None:
    model, data = task.model, mujoco.MjData(task.model)
    for qpos in starts:
        data.qpos[:] = qpos
        mujoco.mj_fwdPosition(model, data)
        if not data.ncon:
            continue
        deepest = int(np.argmin(data.contact.dist))
        depth = -data.contact.dist[deepest]
        if depth > DEEPEST_M:
            one, other = (_body(model, geom) for geom in data.contact.geom[deepest])
            raise ConfigurationError(
                f"{where}: the scene: found {one} and {other} {1000 * depth:.0f} mm inside each "
                "other at a start; allowed: starts at which bodies touch at most"
            )


def _body(model: mujoco.MjModel, geom: int) -> str:
    number = int(model.geom_bodyid[geom])
    return model.body(number).name or f"body {number}"


def _attempts(count: int, max_attempts: int) -> int:
    """How many of the poorest expert that would do fail together as seldom as `UNLUCKY`."""
    share = min(count / max_attempts, 1 - UNLUCKY)
    return int(np.clip(ceil(log(UNLUCKY) / np.log1p(-share)), FEWEST_ATTEMPTS, ATTEMPTS_AT_ONCE))


def _demonstration(
    where: str, task: Demonstrated, attempts: int, rng: np.random.Generator, threads: int
) -> Demonstration:
    """The first success; most experts need one attempt, and those that fail the rest at once."""
    for n in (1, attempts - 1):
        demonstrations, success = attempt(task, task.sample_starts(rng, n), rng, threads)
        if success.any():
            return demonstrations[int(np.argmax(success))]
    raise ExpertError(
        f"{where}: found a task that its expert fails at in {attempts} of {attempts} attempts; "
        "allowed: one that it can do. Bring things into reach, or make the task easier."
    )


def _check_horizon(where: str, task: Demonstrated, shown: Demonstration) -> None:
    takes_s = len(shown) * TIMESTEP_S
    if task.horizon_s < takes_s:
        raise ConfigurationError(
            f"{where}: horizon_s: found {task.horizon_s:g}; allowed: no less than the "
            f"{takes_s:.1f} s that the expert took in an attempt"
        )


def _look(where: str, cameras: Cameras, shown: Demonstration) -> None:
    try:
        for _ in render([shown], cameras, max(1, len(shown) // LOOKS), "mean"):
            pass
    except CameraError as error:
        raise CameraError(f"{where}: {error}") from None
