"""Advice in sentences, each with what it rests on."""

import numpy as np

from t2l.advise.advice import AS_GOOD, LASTS_S, Advice
from t2l.advise.evidence import ALIKE, OTHER, OURS, STUDY, evidence, mean_of
from t2l.advise.exclusions import HOPELESS, Objection, mildest
from t2l.advise.responses import LONGEST_DELAY_S, longest_delay_s
from t2l.advise.shown import FREE
from t2l.advise.trainings import to_train
from t2l.names import listed


def headline(advice: Advice) -> str:
    """The pair of gains, and for whom it is."""
    cell = advice.asked.grid.cells[advice.best]
    own = [advice.asked.joints[j] for j in advice.own]
    but = f", but for {listed(own)}, which cannot have them" if own else ""
    count = len(advice.settled.tried) if advice.settled else 0
    since = f" after {count} training{'s' * (count > 1)}" if count else ""
    what = "cloning" if advice.cloning else "a loop that is damped critically"
    factors = (advice.asked.units != 1).any()
    where = "times the robot's own gains" if factors else "on every joint"
    return (
        f"Kp {cell.kp:g}, Kd {cell.kd:g} {where}{but}: the best of what is left, for {what}{since}"
    )


def as_good(advice: Advice) -> str:
    """The cells that cannot be told from it."""
    cells = advice.asked.grid.cells
    near = [cells[i] for i in np.flatnonzero(advice.as_good) if i != advice.best]
    if not near:
        return "No other pair of the grid is as good by this order."
    said = listed([f"({cell.kp:g}, {cell.kd:g})" for cell in near])
    if advice.settled is not None:
        near = f"within {100 * AS_GOOD:.0f} per cent points of it"
        return f"Expected to succeed {near}, as (Kp, Kd): {said}."
    if advice.cloning is None:
        return f"As near to critical damping, but for a factor of √2, as (Kp, Kd): {said}."
    right = evidence().right(1.0).right
    return (
        f"Not to be told from it, as (Kp, Kd): {said}. Their predicted errors differ by less than "
        f"{100 * (ALIKE - 1):.0f} %, and of measured pairs that differed so little only "
        f"{100 * right:.0f} % were in the right order."
    )


def wants(advice: Advice) -> list[str]:
    """What cloning would take, what it meets, and where the loop is in its way."""
    cloning = advice.cloning
    if cloning is None and advice.asked.shown is not None:
        return [
            "Nothing is known that ranks gains for learning by trying: of the gains that are left, "
            "those damp the median joint critically, and the middle one of them is named."
        ]
    if cloning is None:
        return [
            "Without demonstrations nothing tells how stiff to be: of the gains that are left, "
            "those damp the median joint critically, and the middle one of them is named. Give "
            "--demonstrations or --task."
        ]
    cells, best, found = advice.asked.grid.cells, advice.best, []
    free = int(np.argmin(cloning.error))
    if free != best and advice.settled is None:
        against = [one for one in advice.ruling if one.cell == free]
        kinds = {one.kind for one in against}
        names = [advice.asked.joints[one.joint] for one in against]
        found.append(
            f"Cloning alone would take Kp {cells[free].kp:g}, Kd {cells[free].kd:g}, with "
            f"{100 * cloning.error[free] / cloning.error[best]:.0f} % of the predicted error. "
            f"{listed(names)} {'rules' if len(names) == 1 else 'rule'} it out: "
            f"{listed(sorted(kinds))}."
        )
    single, lasting = (np.sqrt(a[best].mean()) for a in (cloning.amplification, cloning.lasting))
    found.append(
        f"There {100 * single:.0f} % of an error of single commands reaches the arm, and "
        f"{100 * lasting:.0f} % of one that lasts {LASTS_S:g} s: the loop forgives jitter of a "
        "policy more than its bias."
    )
    labels, replay = cloning.labels, cloning.replay
    joints = advice.asked.joints
    far, off = (int(np.argmax(v[best])) for v in (labels.lead_rad, replay.rmse_rad))
    found.append(
        f"Commands run ahead of the arm by up to {1e3 * labels.lead_rad[best, far]:.0f} mrad (RMS, "
        f"{joints[far]}), and a replay at {advice.asked.policy_rate_hz:g} Hz misses the "
        f"demonstrations by {1e3 * replay.rmse_rad[best, off]:.2g} mrad ({joints[off]})."
    )
    fast = labels.fast[best]
    if fast.max() > 0:
        found.append(
            f"{100 * fast.max():.1f} % of the commands of {joints[int(fast.argmax())]} move "
            "faster than the joint may: a controller that limits their speed must be told not to."
        )
    return found


def trying(advice: Advice) -> list[str]:
    """What reinforcement learning wants, and whether cloning's gains leave it that."""
    scales = advice.scales
    if scales is None:
        return []
    cells, best, may = advice.asked.grid.cells, advice.best, advice.allowed.all(axis=1)
    room, joints = scales.room, advice.asked.joints
    found = []
    low, high = scales.low[best], scales.high[best]
    if not np.isfinite(high).any():
        return [
            "The robot's file states no torque limits: an action scale has no upper end. The least "
            f"are {low.min():.2g} to {low.max():.2g} rad under the gains above."
        ]
    tight = int(np.argmin(high / low))
    if room[best] >= 1:
        found.append(
            "Under the gains above, actions that move commands from where the joint is reach what "
            f"is shown within the torque limits. {joints[tight]} has the least room, a factor of "
            f"{room[best]:.2g}."
        )
    else:
        found.append(
            f"Under the gains above, {joints[tight]} has to be asked for more torque at once than "
            f"it has: its actions have to reach {low[tight]:.2g} rad, of which it can give "
            f"{high[tight]:.2g} rad."
        )
    left = np.flatnonzero(may)
    roomy = int(left[np.argmax(room[left])]) if len(left) else best
    if roomy != best:
        most = (
            f"f the pairs that are left, Kp {cells[roomy].kp:g}, Kd {cells[roomy].kd:g} leaves "
            f"most room, a factor of {room[roomy]:.2g}"
        )
        if advice.cloning is None:
            found.append(f"O{most}.")
        else:
            worse = advice.score[roomy] / advice.score[best]
            found.append(
                f"Here both pull apart: o{most}, and has {worse:.2g} times the predicted error "
                "of a clone."
            )
    trials = evidence().trials
    inside, outside = (
        [getattr(one, f"{where}_succeeded") for one in trials] for where in ("inside", "outside")
    )
    found.append(
        f"Where it was measured, of 200 trainings of Joint-Reach under four pairs of gains, those "
        f"with scales in such a range succeeded in {100 * min(inside):.0f} to "
        f"{100 * max(inside):.0f} %, the others in {100 * min(outside):.0f} to "
        f"{100 * max(outside):.0f} %. It is a range to begin a search in; which gains learn "
        "best it does not say."
    )
    return found


def confidence(advice: Advice) -> list[str]:
    """How often this order was right where it was measured, and where nothing is known."""
    ours, theirs = evidence().of(OURS), evidence().of(STUDY)
    if advice.cloning is None:
        return [
            f"Nearness to critical damping told success with a rank correlation of "
            f"{mean_of(ours, 'rho_critical'):.2f} in {len(ours)} grids of ours and "
            f"{mean_of(theirs, 'rho_critical'):.2f} in {len(theirs)} of the study. Cells nearest "
            f"to it succeeded in {100 * mean_of(ours, 'critical'):.0f} % and "
            f"{100 * mean_of(theirs, 'critical'):.0f} %, the best cells in "
            f"{100 * mean_of(ours, 'best'):.0f} % and {100 * mean_of(theirs, 'best'):.0f} %.",
            _of_ringing(),
            *_unknown(advice),
        ]
    (other,) = evidence().of(OTHER)
    rhos = sorted(row.rho for row in (*ours, *theirs))
    said = [
        f"The predicted order and success had a rank correlation of {mean_of(ours, 'rho'):.2f} in "
        f"{len(ours)} grids of ours, what is fitted being fitted without the task at hand, and "
        f"{mean_of(theirs, 'rho'):.2f} in {len(theirs)} of the study ({rhos[0]:.2f} to "
        f"{rhos[-1]:.2f}). Kd/Kp alone has {mean_of(ours, 'rho_ratio'):.2f} and "
        f"{mean_of(theirs, 'rho_ratio'):.2f}, nearness to critical damping "
        f"{mean_of(ours, 'rho_critical'):.2f} and {mean_of(theirs, 'rho_critical'):.2f}.",
        f"On the one grid of another robot, a UR5e with {other.cells} cells, it has "
        f"{other.rho:.2f}, and Kd/Kp {other.rho_ratio:.2f}.",
        f"The cell that it names succeeded less often than the best of its grid by "
        f"{100 * mean_of(ours, 'lost'):.0f} per cent points in ours and "
        f"{100 * mean_of(theirs, 'lost'):.0f} in the study's, on average. It is no place to stop: "
        "train on a few of the cells below.",
    ]
    chance, may = advice.chance(), advice.allowed.all(axis=1)
    left = [i for i in np.flatnonzero(may) if i != advice.best and not advice.as_good[i]]
    if left:
        sure = float(np.mean(chance[left]))
        said.append(
            f"Of the other {len(left)} cells that are left, by measured pairs that differed as "
            f"much, it is better than one with a chance of {100 * sure:.0f} % on average."
        )
    return [*said, _in_worlds(advice), _of_ringing(), *_unknown(advice)]


def _in_worlds(advice: Advice) -> str:
    """How advice of the same knowledge did on simulated machines with hidden effects."""
    row = evidence().in_worlds("explained" if advice.asked.known else "nominal")
    knew = (
        "that was given their effects, each number off by 5 %," if advice.asked.known
        else "that was given the nominal robot alone"
    )  # fmt: skip
    less = "less" if row.lost >= 0 else "more"
    return (
        f"On {row.worlds} simulated machines with hidden effects, to which nothing was fitted, "
        f"advice {knew} named a pair of 16 within 5 per cent points of the best in {row.within}, "
        f"with {100 * abs(row.lost):.0f} points {less} success on average. Critical damping at "
        f"5 Hz did so in {row.critical_within}, the largest Kd/Kp in {row.ratio_within}. Of "
        f"{row.ruled_out} pairs that were ruled out {row.failed} failed."
    )


def _of_ringing() -> str:
    grids = evidence().grids
    best = sum(row.best_rings for row in grids)
    return (
        f"Pairs that ring were {'never' if not best else f'{best} times'} the best of a grid: "
        f"policies under them succeeded in {100 * mean_of(grids, 'in_them'):.0f} % on average, "
        f"under the others in {100 * mean_of(grids, 'in_others'):.0f} %."
    )


def _unknown(advice: Advice) -> list[str]:
    found = [
        "Of transfer from a simulator this says nothing.",
        "All grids are of simulated arms, one pair of gains for all joints.",
    ]
    asked = advice.asked
    if asked.shown is not None and asked.shown.torques == FREE:
        found.append(
            "Torques of the demonstrations are those of a free motion: what contacts and friction "
            "asked for is missing. Give --recorded-kp and --recorded-kd, and it is not."
        )
    if advice.machine.left_out:
        left_out = listed(list(advice.machine.left_out))
        found.append(f"Not in the linear loop, though in the replay: {left_out}.")
    return found


def changes(advice: Advice, measured: bool) -> list[str]:
    """What would change the answer, the most likely first.

    Args:
        measured: whether the machine's effects are known from recordings.
    """
    machine, found = advice.machine, []
    bears = longest_delay_s(machine, *advice.gains.T, advice.asked.least_margin)
    joint = int(np.argmin(bears))
    has = machine.signals.delay_s[joint]
    if bears[joint] < LONGEST_DELAY_S:
        known = f"it has {1e3 * has:.2g} ms" if measured else "which nobody has measured here"
        late = f"later than {1e3 * bears[joint]:.2g} ms in all, {known}"
        found.append(
            f"A loop of {advice.asked.joints[joint]} that is {late}: these gains would then be "
            "too near to unstable."
        )
    cell, grid = advice.asked.grid.cells[advice.best], advice.asked.grid
    for name, gain, values in (("Kp", cell.kp, grid.kp), ("Kd", cell.kd, grid.kd)):
        if len(values) > 1 and gain in (values[0], values[-1]):
            found.append(
                f"A wider grid: {name} {gain:g} is at its edge. Look further by --kp and --kd."
            )
    if not measured:
        found.append(
            "What the real machine adds. Record it (t2l plan, t2l record) and give --logs: delays, "
            "filters and friction then count."
        )
    if advice.cloning is not None:
        cells = advice.asked.grid.cells
        picked = [cells[i] for i in to_train(advice.best, advice.off_critical, advice.left, cells)]
        pairs = listed([f"({cell.kp:g}, {cell.kd:g})" for cell in picked])
        grids = evidence().grids
        found.append(
            f"Policies trained under (Kp, Kd) {pairs}: the best of what is left by prediction, by "
            "Kd/Kp and by critical damping. Over all measured grids the best of such three "
            f"succeeded in {100 * mean_of(grids, 'trained'):.0f} %, the pair named by prediction "
            f"in {100 * mean_of(grids, 'advised_left'):.0f} %, the best of three at random in "
            f"{100 * mean_of(grids, 'trained_at_random'):.0f} %, the best of all in "
            f"{100 * mean_of(grids, 'best'):.0f} %."
        )
        first, *_, last = evidence().settling
        found.append(
            f"--train: on our grids the pair named lost {100 * first.lost:.0f} per cent points "
            f"against the best without trainings and {100 * last.lost:.0f} after "
            f"{last.trainings} that it chose, {100 * last.at_random:.0f} after as many at random."
        )
    return found


def trained(advice: Advice) -> list[str]:
    """What trainings found, and how far that may be off."""
    if advice.settled is None:
        return []
    cells, believed, found = advice.asked.grid.cells, advice.settled.believed, {}
    for one in advice.settled.tried:
        found.setdefault(one.cell, []).append(one.success)
    said = [
        f"Under Kp {cells[i].kp:g}, Kd {cells[i].kd:g} "
        f"{listed([f'{100 * value:.0f} %' for value in values])} of attempts succeeded."
        for i, values in found.items()
    ]
    best = advice.best
    said.append(
        f"Of a policy under Kp {cells[best].kp:g}, Kd {cells[best].kd:g} a success of "
        f"{100 * believed.mean[best]:.0f} % is expected, give or take "
        f"{100 * believed.deviation[best]:.0f} %."
    )
    return said


def exclusions(advice: Advice) -> list[tuple[str, str, int]]:
    """What rules out: kind, sentence and number of cells, a joint after the other."""
    return _told(advice, advice.ruling)


def costs(advice: Advice) -> list[tuple[str, str, int]]:
    """What is to be paid, likewise."""
    return _told(advice, advice.costing)


def hopeless(advice: Advice) -> str:
    """What is ruled out by its predicted error alone, empty if nothing is."""
    which = advice.hopeless & advice.allowed.all(axis=1)
    cells = [advice.asked.grid.cells[i] for i in np.flatnonzero(which)]
    if not cells:
        return ""
    said = listed([f"({cell.kp:g}, {cell.kd:g})" for cell in cells])
    return f"Hopeless by a predicted error of {HOPELESS:g} times the best and more: {said}."


def at_a_price(advice: Advice) -> list[str]:
    """What speaks against the gains that are advised, though it does not rule them out."""
    cells = advice.cells
    return [one.why for one in advice.costing if one.cell == cells[one.joint]]


def _told(advice: Advice, some: list[Objection]) -> list[tuple[str, str, int]]:
    return [(one.kind, one.why, count) for one, count in mildest(some, len(advice.asked.joints))]


def most_common(advice: Advice) -> list[str]:
    """Of each kind the case that rules most pairs out, the mildest of its joint."""
    found: dict[str, tuple[str, int]] = {}
    for kind, why, count in exclusions(advice):
        if count > found.get(kind, ("", 0))[1]:
            found[kind] = why, count
    return [
        f"{why}" + (f" (and {count - 1} more pairs)" if count > 1 else "")
        for why, count in found.values()
    ]
