"""Pairings of gains and behaviours compared; the unit of replication is the training seed.

The study's statement (section III, appendix A-B): a soft arm trained to behave stiffly is stiffer
than a stiff arm trained to behave compliantly, about five times at 32 times softer gains. It holds
here if the least stiff seed of the one is stiffer than the stiffest seed of the other; for three
seeds of each, this is p = 1/20 of an exact one-sided Mann-Whitney U test, the least attainable.
It is told only of policies that hold their pose, and yield steadily when they are pushed.
"""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from t2l.names import heading
from t2l.stats.attainable import least_attainable_p, reportable
from t2l.stats.rank_tests import rank_sum_p
from t2l.stats.text import p_value
from t2l.stats.verdict import ALPHA
from t2l.study.decoupling.summary import holding

HEADERS: dict[str, str] = {"Kp": "$K_p$", "Kd": "$K_d$", "p": "$p$"}


def decoupling_table(trainings: pd.DataFrame, order: Sequence[str]) -> pd.DataFrame:
    """Each pairing, and against the last in `order`.

    Args:
        trainings: one row a pairing and seed, columns `summary.COLUMNS`.

    Returns:
        One row a pairing: pairing, kp, kd, seeds; passive_n_m, of the bare controller;
        stiffness_n_m, the median over seeds, stiffness_least_n_m and stiffness_most_n_m; drift and
        swing, medians; success; gain_ratio, passive_ratio and ratio, of kp, passive_n_m and
        stiffness_n_m over those of the last; ratio_least and ratio_most, of any two seeds; and p,
        one-sided, that stiffness is greater than the last's. Of the last these are NaN, and so is p
        where the least attainable one exceeds `ALPHA`, or a policy of either does not hold its pose
        and yield steadily.
    """
    groups = [trainings[trainings.pairing == name] for name in order]
    rows = []
    for name, group in zip(order, groups, strict=True):
        own, others = group.stiffness_n_m, groups[-1].stiffness_n_m
        row = {
            "pairing": name, "kp": group.kp.iloc[0], "kd": group.kd.iloc[0], "seeds": len(group),
            "passive_n_m": group.passive_n_m.median(), "stiffness_n_m": own.median(),
            "stiffness_least_n_m": own.min(), "stiffness_most_n_m": own.max(),
            "drift": group.drift.median(), "swing": group.swing.median(),
            "success": group.success.mean(),
        } | dict.fromkeys(
            ("gain_ratio", "passive_ratio", "ratio", "ratio_least", "ratio_most", "p"), np.nan
        )  # fmt: skip
        if name != order[-1]:
            row |= {
                "gain_ratio": row["kp"] / groups[-1].kp.iloc[0],
                "passive_ratio": row["passive_n_m"] / groups[-1].passive_n_m.median(),
                "ratio": own.median() / others.median(),
                "ratio_least": own.min() / others.max(),
                "ratio_most": own.max() / others.min(),
                "p": reportable(
                    rank_sum_p(own, others), least_attainable_p(len(own), len(others)), ALPHA
                )
                if holding(pd.concat([group, groups[-1]])).all()
                else np.nan,
            }
        rows.append(row)
    return pd.DataFrame(rows)


def printable_decoupling(table: pd.DataFrame) -> pd.DataFrame:
    """`decoupling_table` as text."""
    compared = [pd.notna(ratio) for ratio in table.ratio]
    spans = zip(table.ratio, table.ratio_least, table.ratio_most, compared, strict=True)
    stiffness = zip(
        table.stiffness_n_m, table.stiffness_least_n_m, table.stiffness_most_n_m, strict=True
    )
    return pd.DataFrame(
        {
            "Pairing": [heading(name) for name in table.pairing],
            "Kp": [f"{kp:g}" for kp in table.kp],
            "Kd": [f"{kd:g}" for kd in table.kd],
            "Seeds": table.seeds.astype(str),
            "Bare controller [N/m]": [f"{k:.0f}" for k in table.passive_n_m],
            "Trained [N/m]": [f"{k:.0f} ({a:.0f} to {b:.0f})" for k, a, b in stiffness],
            "Holds the pose": [
                "not known" if pd.isna(share) else f"{100 * share:.0f} %" for share in table.success
            ],
            "Drift when pushed": [f"{100 * drift:.0f} %" for drift in table.drift],
            "Swing when pushed": [f"{100 * swing:.0f} %" for swing in table.swing],
            "Gain, over the last": [_times(r) for r in table.gain_ratio],
            "Stiffness, over the last": [
                f"{r:.3g} ({a:.3g} to {b:.3g})" if known else "–" for r, a, b, known in spans
            ],
            "p": [
                p_value(p) if pd.notna(p) else ("not told" if known else "–")
                for p, known in zip(table.p, compared, strict=True)
            ],
        }
    )


def _times(ratio: float) -> str:
    return f"{ratio:.3g}" if pd.notna(ratio) else "–"
