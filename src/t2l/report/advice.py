"""Advice as one page that needs nothing but a browser."""

import base64
import math
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path

from markupsafe import Markup

from t2l.advise import words as said
from t2l.advise.advice import Advice
from t2l.advise.evidence import evidence
from t2l.artefacts import write_text
from t2l.diagnose.files import REPORT
from t2l.report import words
from t2l.report.templating import templates


def write_advice_page(
    advice: Advice, pictures: Mapping[str, Path], folder: Path, measured: bool
) -> None:
    """Write ``report.html``.

    Args:
        pictures: PNG files by what they are named in the template: maps, reasons.
        measured: whether the machine's effects are known from recordings.
    """
    environment = templates(
        {"number": words.number, "isinf": math.isinf, "sentence": words.sentence}
    )
    found, joints = advice.responses, advice.asked.joints
    rows = [
        {
            "joint": name, "kp": kp, "kd": kd, "own": j in advice.own,
            "natural": found.natural_hz[at], "over": 100 * found.overshoot[at],
            "margin": found.margin[at], "lag": 1e3 * found.lag_s[at],
            "scale": advice.scales
            and (float(advice.scales.low[at]), float(advice.scales.high[at])),
            "inertia": advice.machine.inertia[:, j].mean(),
        }
        for j, (name, (kp, kd)) in enumerate(zip(joints, advice.gains, strict=True))
        for at in [(advice.cells[j], j)]
    ]  # fmt: skip
    page = environment.get_template("advice.html").render(
        robot=Path(advice.asked.model.robot).stem,
        advice=advice,
        headline=said.headline(advice),
        as_good=said.as_good(advice),
        wants=said.wants(advice),
        trying=said.trying(advice),
        excluded=said.exclusions(advice),
        hopeless=said.hopeless(advice),
        costs=said.costs(advice),
        trained=said.trained(advice),
        at_a_price=said.at_a_price(advice),
        confidence=said.confidence(advice),
        changes=said.changes(advice, measured),
        measured=measured,
        rows=rows,
        grids=evidence().grids,
        pairs=evidence().pairs,
        pictures={
            name: Markup("data:image/png;base64,") + base64.b64encode(path.read_bytes()).decode()
            for name, path in pictures.items()
        },
        style=Markup((files("t2l.report") / "templates" / "page.css").read_text()),
    )
    write_text(page, folder / REPORT)
