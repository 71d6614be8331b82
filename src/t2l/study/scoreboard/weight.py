"""How much each row says: which finding it is evidence of, and what speaks against counting it.

Many rows rest on one contrast. Rows of one finding share data, or would come out alike for one
reason; so findings are counted, and not rows.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import pandas as pd

from t2l.stats.verdict import Verdict


@dataclass(frozen=True)
class Independent:
    """One finding.

    Attributes:
        words: what it says, as a heading.
        keys: of the claims that are evidence of it.
        why: they are one.
    """

    words: str
    keys: tuple[str, ...]
    why: str = ""


FINDINGS = (
    Independent(
        "Damping helps behaviour cloning",
        (
            "co_block_stack", "co_handover", "co_unloading", "co_loading", "co_dishwasher",
            "co_mug", "damping_helps", "overdamped_once_compliant", "ablation_regression",
            "ablation_diffusion", "ablation_transformer", "ablation_lerobot_act",
            "ablation_lerobot_diffusion", "ablation_classes", "ablation_history", "ablation_chunk",
            "ablation_joint_delta", "ablation_task_space", "ablation_10_hz",
            "ablation_50_demonstrations", "ablation_900_demonstrations", "ablation_images",
            "ablation_no_gravity_compensation", "another_robot",
        ),
        "CO against all others: damping alone satisfies it",
    ),
    Independent(
        "Compliance helps behaviour cloning beside damping",
        ("stiffness_hurts", "compliant_once_overdamped", "pooled_slopes", "end_to_end"),
        "the first two are of the same collections",
    ),
    Independent(
        "Demonstrations can be retargeted",
        ("retargeting_success", "retargeting_error", "retargeting_degrades"),
        "the same replays",
    ),
    Independent(
        "Commands of compliant gains are harder to fit, and succeed more",
        ("compliant_loss_higher", "loss_misleads", "loss_falls_with_attenuation"),
        "the same losses",
    ),
    Independent(
        "Success grows faster with demonstrations at CO", ("scaling",)
    ),
    Independent(
        "Independent errors move a joint by Kp / Kd, whatever its mass",
        ("variance_theorem", "variance_mass"),
        "the same simulations of a linear joint",
    ),
    Independent(
        "The effective error governs success",
        ("effective_error", "effective_beats_loss", "effective_beats_ratio"),
        "the same policies",
    ),
    Independent(
        "Compliant, overdamped gains forgive noise on actions",
        ("noise_robustness", "noise_stiff_fails"),
        "the same replays",
    ),
    Independent(
        "A policy exists under every gain",
        (
            "existence_joint_reach", "existence_end_effector_reach", "existence_lift",
            "existence_drawer", "existence_g1", "existence_allegro", "existence_nonprehensile",
        ),
    ),
    Independent(
        "Gains decide how many action scales succeed, in each task otherwise",
        ("landscape", "no_easier_regime"),
        "the same searches",
    ),
    Independent(
        "Training is alike under every gain",
        ("sample_efficiency", "training_stability"),
        "the same trainings",
    ),
    Independent(
        "Identification leaves least at SO, and most at CO",
        ("identification_so_lowest", "identification_factor", "identification_co_highest"),
        "the same 49 cells",
    ),
    Independent(
        "Transfer is worst at SO",
        (
            "transfer_decision", "transfer_joint_reach", "transfer_joint_reach_randomised",
            "transfer_end_effector_reach", "slopes_joint_reach", "slopes_joint_reach_randomised",
            "slopes_end_effector_reach", "oscillation", "oscillation_randomised",
        ),
        "the same policies and rollouts",
    ),
    Independent("A threshold tells jitter", ("oscillation_modes",)),
    Independent(
        "Slower policies jitter less", ("policy_rate", "policy_rate_sharpest"), "the same policies"
    ),
    Independent("Outputs of the policy differ where motions do", ("network_error",)),
    Independent("What is identified well transfers badly", ("inverse_relation",)),
    Independent(
        "Stiffness of a task is not the gain's",
        ("stiff_behaviour", "stiffness_ratio"),
        "the same ten trainings",
    ),
    Independent(
        "People do not mind compliant gains",
        ("teleoperation_success", "teleoperation_time", "teleoperation_rating"),
    ),
    Independent("Public data sets have stiff gains", ("stiff_datasets",)),
)  # fmt: skip
OF: Mapping[str, Independent] = {key: finding for finding in FINDINGS for key in finding.keys}

_LINEAR = "a linear joint is set beside linear theory, with a hold time that the paper lacks"
_UNIT = "commands scale with 1 / Kp, and so does their error in rad²"
_TWELVE = "in twelve cells the study's own errors would not pass either"
# where another verdict was hardly possible, and why
FORESEEABLE: Mapping[str, str] = {
    "retargeting_degrades": "four corners can give no p below 0.06",
    "variance_theorem": _LINEAR,
    "variance_mass": _LINEAR,
    "compliant_loss_higher": _UNIT,
    "loss_falls_with_attenuation": _UNIT,
    "no_easier_regime": "one task was searched",
    "transfer_joint_reach": _TWELVE,
    "slopes_joint_reach": _TWELVE,
    "network_error": "both errors are of the same pair of rollouts",
}

_EPOCHS = "150 epochs were taken after CO had been behind SO with 50, "
_ELSEWHERE = f"{_EPOCHS}in other collections"
_THERE = f"{_EPOCHS}with the same demonstrations"
_BEFORE = f"{_EPOCHS}in Block Stack"
_ANEW = "collections became the unit when their success was known, these numbers not yet"
_FIRST = f"collections became the unit after the cells of a first one were known; {_BEFORE}"
_LIMITS = "that policies keep the limits was added after it was known that none does"
_LESS = "that less than the share tells nothing was written after the trainings"
_STOPS = "stops counted as jitter before"
_SEARCH = (
    "updates, and what ranks trials, were changed after a first search had given no policy that "
    "works"
)
_ROBOT = "the robot is a second version, made after policies had not failed on the first"
_TRANSFER = f"{_LIMITS}; {_SEARCH}; {_ROBOT}"
# what of a rule, or of what it judges, was written or changed after data had been seen
AFTERWARDS: Mapping[str, str] = {
    **dict.fromkeys(
        ("co_block_stack", "stiffness_hurts", "damping_helps", "compliant_once_overdamped",
         "overdamped_once_compliant"), _ELSEWHERE),
    **dict.fromkeys(
        ("co_handover", "co_unloading", "co_loading", "co_dishwasher", "co_mug"), _FIRST),
    **dict.fromkeys(("another_robot", "ablation_no_gravity_compensation"), _BEFORE),
    **dict.fromkeys(
        ("ablation_regression", "ablation_diffusion", "ablation_lerobot_act",
         "ablation_lerobot_diffusion", "ablation_chunk", "ablation_joint_delta",
         "ablation_task_space", "ablation_10_hz", "ablation_50_demonstrations",
         "ablation_900_demonstrations", "scaling"), _THERE),
    "pooled_slopes": f"the rule was written after the six grids had been seen; {_BEFORE}",
    "end_to_end": f"the unit was the training seed before, and the verdict reproduced; {_BEFORE}",
    "ablation_transformer": "150 epochs in place of 50, which gave p 0.53",
    "ablation_classes": "the row was written after two of the classes; it takes the Transformer's "
    "150 epochs",
    "ablation_history": "that some policy works was added after it was known that none does",
    "ablation_images": "the unit was the training seed before, and the verdict not reproduced; "
    "shifts of pictures were added after training without them had failed",
    **dict.fromkeys(
        ("compliant_loss_higher", "loss_misleads", "effective_error",
         "loss_falls_with_attenuation"), _ANEW),
    "effective_beats_loss": "signed correlations were compared before, and the verdict reproduced; "
    + _ANEW,
    "effective_beats_ratio": f"the row was added after the correlations were known; {_ANEW}",
    "existence_joint_reach": "trials counted before; the rule was written after the trainings",
    "existence_end_effector_reach": "jitter was a failure before; the rule without it was written "
    "after those policies had failed by jitter alone, and before any of these was trained",
    "existence_drawer": _LESS,
    **dict.fromkeys(
        ("existence_lift", "existence_g1"),
        f"trainings that time had cut short were made again in full; {_LESS}"),
    "sample_efficiency": "the unit was changed, and the slowest tenth added, after the trainings",
    "training_stability": "the unit was changed after the trials",
    **dict.fromkeys(
        ("identification_so_lowest", "identification_factor", "identification_co_highest"), _ROBOT),
    "transfer_decision": f"{_SEARCH}; {_ROBOT}",
    **dict.fromkeys(
        ("transfer_joint_reach", "slopes_joint_reach", "network_error", "inverse_relation"),
        _TRANSFER),
    **dict.fromkeys(
        ("oscillation", "policy_rate", "policy_rate_sharpest"), f"{_STOPS}; {_TRANSFER}"),
    "oscillation_modes": f"{_STOPS}; that both modes must be there was added; {_ROBOT}",
    **dict.fromkeys(
        ("stiff_behaviour", "stiffness_ratio"),
        "how stiffness is measured was changed after it was known that no tool rests"),
}  # fmt: skip


def by_finding(table: pd.DataFrame) -> pd.DataFrame:
    """A row a finding: how its claims came out.

    Columns `finding`, `rows`, a verdict each, `why`; and of those that are reproduced `numbers`,
    how many have a number in the study, and `contestable`, of how many another verdict was
    possible.

    Args:
        table: as `t2l.study.scoreboard.table.scoreboard` makes it.
    """
    rows = []
    for finding in FINDINGS:
        own = table[table.id.isin(finding.keys)]
        verdicts = {str(verdict): int((own.verdict == verdict).sum()) for verdict in Verdict}
        won = own[own.verdict == Verdict.REPRODUCED]
        counted = {
            "numbers": int(won.number.sum()),
            "contestable": int((won.foreseeable == "").sum()),
        }
        rows.append({"finding": finding.words, "rows": len(own), **verdicts, **counted,
                     "why": finding.why})  # fmt: skip
    return pd.DataFrame(rows)


def independent(table: pd.DataFrame) -> int:
    """How many findings have a row that is reproduced."""
    return int((by_finding(table)[str(Verdict.REPRODUCED)] > 0).sum())


def contestable(table: pd.DataFrame) -> int:
    """How many findings have a row that is reproduced and could have come out otherwise."""
    return int((by_finding(table).contestable > 0).sum())
