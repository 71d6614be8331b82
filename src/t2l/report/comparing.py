"""Sections about a comparison: what was compared, where the error is, what it follows."""

from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any

from t2l.diagnose.results import Compared, Found, same_gains
from t2l.report.payload import (
    COARSEST,
    conditions_of,
    recordings_to_show,
    worst,
)
from t2l.report.pieces import choice, figure, held_out, shares
from t2l.report.words import listed, mrad, number, percent, readable, sentence, span

MOST_FOLLOWED = 5


def robot(numbers: dict[str, Any]) -> str:
    """The robot's name: known, or that of its MJCF file."""
    return Path(numbers["robot"]).stem


def what(found: Found) -> str:
    """Which robot, recordings, gains and rates."""
    compared = found.compared[0]
    numbers, logs = compared.numbers, compared.numbers["logs"]
    total = sum(log["duration_s"] for log in logs)
    kp = [value for log in logs for value in log["kp"]]
    kd = [value for log in logs for value in log["kd"]]
    compensated = {log["gravity_compensation"] for log in logs}
    gravity = {True: "cancelled by the machine", False: "not cancelled by the machine"}
    joints = compared.traces.joints
    effects = [readable(name) for name in numbers["effects"]]
    many = f"{len(logs)} recordings" if len(logs) > 1 else "one recording"
    facts = [
        ("robot", f"{escape(numbers['robot'])}, joints {escape(listed(joints))}"),
        ("recordings", f"{many}, {number(total)} s together"),
        ("gains", f"Kp {span(kp)} N·m/rad (stiffness), Kd {span(kd)} N·m·s/rad (damping)"),
        ("commands", f"position targets at {span((x['command_rate_hz'] for x in logs), 'Hz')}"),
        ("control loop", f"torques at {span((x['control_rate_hz'] for x in logs), 'Hz')}"),
        ("gravity", listed([gravity[value] for value in sorted(compensated)])),
        (
            "model as it came" if len(found.compared) > 1 else "model",
            f"the robot's MJCF file with {escape(listed(effects))}"
            if effects
            else "the robot's MJCF file, as it is",
        ),
    ]
    if found.steps:
        facts.insert(2, ("held out", held_out(found.steps[0])))
    rows = "".join(f"<dt>{key}</dt><dd>{value}</dd>" for key, value in facts)
    return (
        "<h2>What was compared</h2>\n<p>Every recording was simulated from its measured start, "
        "with its own commands, gains and rates; the error is measured minus simulated "
        f'position.</p>\n<dl class="facts">{rows}</dl>'
    )


def contradictions(numbers: dict[str, Any]) -> str:
    """A warning about recordings that cannot both be true; empty where there are none."""
    if not numbers["contradictions"]:
        return ""
    items = "".join(f"<p>{sentence(c['message'])}</p>" for c in numbers["contradictions"])
    return (
        f'<div class="note"><p><b>Recordings contradict each other.</b> No model can fit both; '
        f"something unrecorded differed.</p>{items}</div>"
    )


def _joint_options(compared: Compared) -> list[tuple[int, str]]:
    return list(enumerate(compared.traces.joints))


def _worst_joint(compared: Compared) -> int:
    shares = [compared.numbers["joints"][name]["share"] for name in compared.traces.joints]
    return shares.index(max(shares))


def where(found: Found) -> str:
    """Findings, error by gains, error by joint."""
    compared = found.compared[0]
    both = len(found.compared) > 1
    parts = ["<h2>Where the error is</h2>"]
    if compared.numbers["findings"]:
        parts.append(
            "<p>Joints and conditions that hold more of the squared error than of the samples"
            f"{', in the model as it came' if both else ''}; they may overlap.</p>"
        )
        parts.append(shares((f["share"], f["sentence"]) for f in compared.numbers["findings"]))
    options = _joint_options(compared)
    if same_gains(compared) and len(options) > 1:
        options = [(-1, "all together"), *options]
    chosen = options[0][0] if options[0][0] == -1 else _worst_joint(compared)
    plots = "".join(
        f'<div class="plot" data-plot="cells" data-model="{i}"></div>'
        for i in range(len(found.compared))
    )
    parts.append(
        figure(
            f'<div class="pair">{plots}</div>' if both else plots,
            "RMS position error in mrad for each cell, that is, each pair of gains: stiffness "
            "Kp to the right, damping Kd upward. Empty where nothing was recorded.",
            choice("cells", "joint", "joint", options, chosen),
        )
    )
    parts.append(_joint_table(found))
    return "\n".join(parts)


def _joint_table(found: Found) -> str:
    head = "".join(f'<th class="n">{escape(c.label)}</th>' for c in found.compared)
    if len(found.compared) == 1:
        head = '<th class="n">RMS error</th>'
    rows = ""
    for name in found.compared[0].traces.joints:
        errors = "".join(
            f'<td class="n">{mrad(c.numbers["joints"][name]["rmse_q_rad"])}</td>'
            for c in found.compared
        )
        share = percent(found.compared[0].numbers["joints"][name]["share"])
        rows += f'<tr><td>{escape(name)}</td>{errors}<td class="n">{share}</td></tr>'
    shares = "share of squared error" + (", before" if len(found.compared) > 1 else "")
    return (
        f'<div class="scroll"><table><tr><th>joint</th>{head}<th class="n">{shares}</th></tr>'
        f"{rows}</table></div>"
    )


def overlays(found: Found) -> str:
    """Measured and simulated motion, of a recording and a joint to choose."""
    compared = found.compared[0]
    traces, logs = compared.traces, compared.numbers["logs"]
    shown = recordings_to_show(traces)
    held = found.heldout

    def label(i: int) -> str:
        text = f"{traces.recordings[i]} · {mrad(logs[i]['rmse_q_rad'])}"
        return f"{text} · held out" if traces.recordings[i] in held else text

    recording, joint = worst(traces, shown)
    options = [(place, label(i)) for place, i in enumerate(shown)]
    caption = (
        "Above: the commanded, measured and simulated position. Below: measured minus simulated. "
        "At first the recording and joint with the largest error"
        f"{' of the model as it came' if len(found.compared) > 1 else ''}; the number beside a "
        "recording is its RMS error over all joints."
    )
    if len(shown) < len(traces.recordings):
        caption += (
            f" {len(shown)} of {len(traces.recordings)} recordings are here, from the best to the "
            f"worst, and at most every {COARSEST}th sample is left."
        )
    choices = choice("overlay", "recording", "recording", options, recording) + choice(
        "overlay", "joint", "joint", _joint_options(compared), joint
    )
    return "<h2>Measured and simulated motion</h2>\n" + figure(
        '<div class="plot" data-plot="overlay"></div>', caption, choices
    )


def follows(found: Found) -> str:
    """The missing torque and the error over a condition to choose."""
    compared = found.compared[0]
    ordered = conditions_of(compared.traces)
    first = next(
        (f["condition"] for f in compared.numbers["follows"] if f["condition"] in ordered),
        ordered[0],
    )
    names = [(i, name) for i, name in enumerate(ordered)]
    top = compared.numbers["follows"][:MOST_FOLLOWED]
    told = (
        "<p>The <dfn>missing torque</dfn> is the torque on each joint that would explain the "
        "error: stiffness times it, plus damping times its rate, plus inertia times its "
        "acceleration. Unlike the error it is alike at all gains, so it shows which condition the "
        "error obeys.</p>"
    )
    if top:
        told += shares((f["fraction"], f["sentence"]) for f in top)
        if len(found.compared) > 1:
            told += '<p class="soft">All of the model as it came.</p>'
    choices = (
        choice("conditions", "joint", "joint", _joint_options(compared), _worst_joint(compared))
        + choice("conditions", "condition", "against", names, ordered.index(first))
        + choice(
            "conditions",
            "quantity",
            "show",
            [("torque", "missing torque"), ("error", "position error")],
            "torque",
        )
    )
    caption = (
        "Dots are single samples, lines their mean. Friction jumps with the direction, a payload "
        "follows the gravity load, inertia the acceleration; a flat line at zero is a model that "
        "is right."
    )
    return (
        "<h2>What the error follows</h2>\n"
        + told
        + figure('<div class="plot" data-plot="conditions"></div>', caption, choices)
    )


def spectrum(found: Found) -> str:
    """The error over frequency."""
    compared = found.compared[0]
    caption = (
        "How much of the error swings at which frequency, averaged over the recordings. A peak "
        "is an oscillation that one side has and the other has not. The dashed line is white "
        "noise of the size of the noise floor."
    )
    joints = choice("spectrum", "joint", "joint", _joint_options(compared), _worst_joint(compared))
    return "<h2>Frequencies of the error</h2>\n" + figure(
        '<div class="plot" data-plot="spectrum"></div>', caption, joints
    )


def recordings(found: Found) -> str:
    """The error of every recording, folded away."""
    heads = "".join(
        f'<th class="n">{escape(c.label) if len(found.compared) > 1 else "RMS error"}</th>'
        for c in found.compared
    )
    rows = ""
    for i, log in enumerate(found.compared[0].numbers["logs"]):
        errors = "".join(
            f'<td class="n">{mrad(c.numbers["logs"][i]["rmse_q_rad"])}</td>' for c in found.compared
        )
        held = "held out" if log["name"] in found.heldout else ""
        rows += (
            f"<tr><td>{escape(log['name'])}</td><td class='n'>{_gain(log['kp'])}</td>"
            f"<td class='n'>{_gain(log['kd'])}</td><td class='n'>{number(log['duration_s'])} s</td>"
            f"{errors}<td>{held}</td></tr>"
        )
    return (
        "<h2>Recordings</h2>\n<details><summary>Error of each recording</summary>"
        '<div class="scroll"><table><tr><th>recording</th><th class="n">Kp</th><th class="n">Kd'
        f'</th><th class="n">duration</th>{heads}<th></th></tr>{rows}</table></div></details>'
    )


def _gain(values: Sequence[float]) -> str:
    return "/".join(f"{v:g}" for v in (values if len(set(values)) > 1 else values[:1]))
