"""How far a policy's rollouts on the robot depart from those in its simulator."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from t2l.environment.limits import JITTER_RAD_S, LIMITS, jitter
from t2l.gains import Cell
from t2l.policies import Policy
from t2l.transfer.deploy import LOG_RATE_HZ, Rollouts

if TYPE_CHECKING:
    import pandas as pd

TRACE_SIGNALS = ("q", "dq", "q_des")
ROLLOUT_COLUMNS = (
    "kp", "kd", "seed", "rollout", "trajectory_error", "nn_error", "jitter_rad_s",
    "jitter_failure", "jitter_rad_s_sim", "jitter_failure_sim", "success", "success_sim",
    "stopped", "stopped_sim", "duration_s",
)  # fmt: skip


def trajectory_error(real: Rollouts, sim: Rollouts) -> np.ndarray:
    """E, (n,): mean over joints and time of (q_sim − q_real)² + (q̇_sim − q̇_real)².

    The study's (section IV-C), whose published cells are means over joints. Over the whole
    horizon: a robot that was stopped counts as standing where it was until the end, so that no
    rollout is left out and none is judged by its motion alone.
    """
    squares = [
        (one - other) ** 2
        for one, other in zip(*map(standing_where_stopped, (sim, real)), strict=True)
    ]
    return sum(squares).mean(axis=(0, 2))


def standing_where_stopped(rollouts: Rollouts) -> tuple[np.ndarray, np.ndarray]:
    """q and q̇ (nsample, n, njoint) with stopped robots held still where they were stopped."""
    q, dq = rollouts.q.copy(), rollouts.dq.copy()
    for i in np.flatnonzero([bool(reason) for reason in rollouts.stopped]):
        known = np.flatnonzero(np.isfinite(q[:, i]).all(axis=1))
        last = known[-1] if len(known) else 0
        q[last + 1 :, i] = q[last, i]
        dq[last + 1 :, i] = 0.0
    return q, dq


def nn_error(policy: Policy, real: Rollouts, sim: Rollouts) -> np.ndarray:
    """RMS over time and joints of π(s_sim) − π(s_real) on the two sequences of states, (n,).

    Over the decisions that both took; NaN where one was stopped before its first.
    """
    ndecision, n, nobs = real.observation.shape
    here, there = (
        policy.action(run.observation.reshape(-1, nobs)).reshape(ndecision, n, -1)
        for run in (real, sim)
    )
    return np.sqrt(_mean(((there - here) ** 2).mean(axis=2)))


def shaking(rollouts: Rollouts) -> np.ndarray:
    """`t2l.environment.limits.jitter` of rollouts, (n,) rad/s; NaN where a robot was stopped."""
    return jitter(rollouts.dq, LOG_RATE_HZ)


def rollout_table(
    policy: Policy, cell: Cell, seed: int, real: Rollouts, sim: Rollouts
) -> "pd.DataFrame":
    """One row a rollout: `ROLLOUT_COLUMNS`, and by limit how many samples of either violated it.

    A rollout fails by jitter where it jitters to its end. One that was stopped shows no such end,
    so it is no jitter, whatever it did before; `stopped` says why. A success does neither.

    Args:
        seed: of the policy's training.
    """
    import pandas as pd

    of_each = {}
    for suffix, run in (("", real), ("_sim", sim)):
        deviation = shaking(run)
        stopped = np.array([bool(reason) for reason in run.stopped])
        jitters = deviation > JITTER_RAD_S  # never of NaN, where it was stopped
        of_each |= {
            f"jitter_rad_s{suffix}": deviation,
            f"jitter_failure{suffix}": jitters,
            f"success{suffix}": run.success & ~stopped & ~jitters,
            f"stopped{suffix}": list(run.stopped),
        }
        of_each |= {
            f"violations_{name}{suffix}": run.violated[:, :, i].sum(axis=0)
            for i, name in enumerate(LIMITS)
        }
    return pd.DataFrame(
        {
            "kp": cell.kp,
            "kd": cell.kd,
            "seed": seed,
            "rollout": np.arange(len(real.success)),
            "trajectory_error": trajectory_error(real, sim),
            "nn_error": nn_error(policy, real, sim),
            **of_each,
            "duration_s": np.isfinite(real.q_des[:, :, 0]).sum(axis=0) / LOG_RATE_HZ,
        }
    )


def trace_table(real: Rollouts, sim: Rollouts, joints: Sequence[str]) -> "pd.DataFrame":
    """One row a sample: rollout, where (real or sim), time, and signals by joint."""
    import pandas as pd

    parts = []
    for where, run in (("real", real), ("sim", sim)):
        for i in range(len(run.success)):
            columns = {
                f"{signal}.{joint}": getattr(run, signal)[:, i, j].astype(np.float32)
                for signal in TRACE_SIGNALS
                for j, joint in enumerate(joints)
            }
            parts.append(pd.DataFrame({"rollout": i, "where": where, "time": run.time} | columns))
    return pd.concat(parts, ignore_index=True).astype({"where": "category"})


def observation_table(real: Rollouts, sim: Rollouts, names: Sequence[str]) -> "pd.DataFrame":
    """One row a decision: rollout, where, and what the policy saw, by `names` of its columns."""
    import pandas as pd

    parts = []
    for where, run in (("real", real), ("sim", sim)):
        for i in range(len(run.success)):
            seen = run.observation[:, i].astype(np.float32)
            frame = pd.DataFrame(seen, columns=list(names))
            parts.append(frame.assign(rollout=i, where=where))
    return pd.concat(parts, ignore_index=True).dropna().astype({"where": "category"})


def _mean(values: np.ndarray) -> np.ndarray:
    """Over the first axis, of numbers; NaN where there is none."""
    known = np.isfinite(values)
    with np.errstate(invalid="ignore"):
        return np.where(known, values, 0).sum(axis=0) / known.sum(axis=0)
