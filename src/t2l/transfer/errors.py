"""How far a policy's rollouts on the robot depart from those in its simulator."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from t2l.gains import Cell
from t2l.policies import Policy
from t2l.rl.constraints import NAMES
from t2l.transfer.deploy import LOG_RATE_HZ, Rollouts

if TYPE_CHECKING:
    import pandas as pd

# the study's: standard deviation of a joint's velocity over the last seconds of a rollout
JITTER_RAD_S = 0.04
JITTER_WINDOW_S = 2.0

TRACE_SIGNALS = ("q", "dq", "q_des")
ROLLOUT_COLUMNS = (
    "kp", "kd", "rollout", "trajectory_error", "nn_error", "jitter_rad_s", "jitter_failure",
    "jitter_rad_s_sim", "jitter_failure_sim", "success", "success_sim", "stopped", "duration_s",
)  # fmt: skip


def trajectory_error(real: Rollouts, sim: Rollouts) -> np.ndarray:
    """E = mean over time of ‖q_sim − q_real‖² + ‖q̇_sim − q̇_real‖², (n,), the study's.

    Over the instants at which neither was stopped; NaN where there is none.
    """
    squares = ((sim.q - real.q) ** 2).sum(axis=2) + ((sim.dq - real.dq) ** 2).sum(axis=2)
    return _mean(squares)


def nn_error(policy: Policy, real: Rollouts, sim: Rollouts) -> np.ndarray:
    """RMS over time and joints of π(s_sim) − π(s_real) on the two sequences of states, (n,)."""
    ndecision, n, nobs = real.observation.shape
    here, there = (
        policy.action(run.observation.reshape(-1, nobs)).reshape(ndecision, n, -1)
        for run in (real, sim)
    )
    return np.sqrt(_mean(((there - here) ** 2).mean(axis=2)))


def jitter(rollouts: Rollouts) -> np.ndarray:
    """Largest standard deviation of any joint's velocity over the last 2 s, (n,) rad/s.

    NaN where a rollout was stopped before it lasted that long.
    """
    window = round(JITTER_WINDOW_S * LOG_RATE_HZ)
    found = []
    for dq in rollouts.dq.transpose(1, 0, 2):
        moved = dq[np.isfinite(dq).all(axis=1)][-window:]
        found.append(moved.std(axis=0).max() if len(moved) == window else np.nan)
    return np.array(found)


def rollout_table(policy: Policy, cell: Cell, real: Rollouts, sim: Rollouts) -> "pd.DataFrame":
    """One row a rollout: `ROLLOUT_COLUMNS`, and by constraint how often either violated it."""
    import pandas as pd

    shaking, failed = {}, {}
    for suffix, run in (("", real), ("_sim", sim)):
        deviation = jitter(run)
        failure = pd.array(deviation > JITTER_RAD_S, "boolean")
        failure[np.isnan(deviation)] = pd.NA
        shaking[f"jitter_rad_s{suffix}"] = deviation
        failed[f"jitter_failure{suffix}"] = failure
    counts = {
        f"violations_{name}{suffix}": run.violated[:, :, i].sum(axis=0)
        for suffix, run in (("", real), ("_sim", sim))
        for i, name in enumerate(NAMES)
    }
    return pd.DataFrame(
        {
            "kp": cell.kp,
            "kd": cell.kd,
            "rollout": np.arange(len(real.success)),
            "trajectory_error": trajectory_error(real, sim),
            "nn_error": nn_error(policy, real, sim),
            **shaking,
            **failed,
            "success": real.success,
            "success_sim": sim.success,
            "stopped": list(real.stopped),
            "duration_s": np.isfinite(real.q[:, :, 0]).sum(axis=0) / LOG_RATE_HZ,
            **counts,
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
