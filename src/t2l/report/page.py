"""The page itself: one HTML file that needs nothing but a browser."""

import re
from collections.abc import Iterable, Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

from jinja2 import Environment
from markupsafe import Markup
from plotly.offline import get_plotlyjs

from t2l.artefacts import write_text
from t2l.diagnose.files import REPORT
from t2l.diagnose.findings import percent
from t2l.diagnose.fronts import fronts
from t2l.diagnose.results import Found, read_found, titles_of
from t2l.diagnose.settings import CERTAIN
from t2l.names import listed, with_minus
from t2l.plotting.style import COLOURS
from t2l.report import words
from t2l.report.menus import menus
from t2l.report.payload import COARSEST, payload, unmapped
from t2l.report.saved import saved
from t2l.report.templating import templates
from t2l.report.view import LIMITS, view


def write_report(folder: Path | str) -> Path:
    """Write ``report.html`` into a folder that `t2l compare`, `diagnose` or `explain` filled.

    Raises:
        ArtefactError: the folder holds none of their results, or a malformed one.
    """
    path = Path(folder) / REPORT
    write_text(render(read_found(folder)), path)
    return path


def render(found: Found) -> str:
    """The page as HTML."""
    template = _environment().get_template(f"{_story(found)}.html")
    seen = view(found) if found.compared else None
    kept = saved(found)
    return template.render(
        found=found,
        CERTAIN=CERTAIN,
        titles=titles_of(found),
        fronts=fronts(found),
        data=payload(found)
        | {"colours": COLOURS, "view": seen, "files": {file.name: file.text for file in kept}},
        files=[(file.name, file.what) for file in kept],
        view=seen,
        view_limits=LIMITS,
        three=_asset("vendor", "three.min.js") if seen else "",
        view_script=_asset("templates", "view.js") if seen else "",
        style=_asset("templates", "page.css"),
        script=_asset("templates", "page.js"),
        tables=_asset("templates", "tables.js"),
        plotly=Markup(get_plotlyjs()),
        **(_of_comparison(found) if found.compared else {"robot": "the robot"}),
    )


def _story(found: Found) -> str:
    if found.explanation is not None:
        return "explain"
    if found.proposal is not None:
        return "propose"
    return "compare" if found.diagnosis is None else "diagnose"


def _of_comparison(found: Found) -> dict[str, Any]:
    first = found.compared[0]
    return {
        "numbers": first.numbers,
        # a known name, or an MJCF file
        "robot": Path(first.numbers["robot"]).stem,
        "joints": first.traces.joints,
        "both": len(found.compared) == 2,
        "menus": menus(found),
        "unmapped": unmapped(first),
        "coarsest": COARSEST,
    }


def _environment() -> Environment:
    environment = templates({
        filter.__name__: filter
        for filter in (
            words.estimate, words.gains, listed, words.mrad, words.number, percent,
            words.capital, words.sentence, words.span, words.title_in, with_minus,
            by_share, by_value, contents,
        )
    })  # fmt: skip
    environment.policies["json.dumps_kwargs"] = {"separators": (",", ":"), "allow_nan": False}
    return environment


def contents(story: str) -> list[tuple[str, Markup]]:
    """Id and heading of every section of a story, as `pieces.html` writes them."""
    found = re.findall(r'<h2 id="([^"]+)">(.*?) <a class="anchor"', story)
    return [(name, Markup(heading)) for name, heading in found]


def by_value(
    entries: Iterable[Mapping[str, Any]], key: str, largest_first: bool = False
) -> list[Mapping[str, Any]]:
    """Entries in order of a number, those without it last."""
    known = [entry for entry in entries if entry[key] is not None]
    unknown = [entry for entry in entries if entry[key] is None]
    return sorted(known, key=lambda entry: entry[key], reverse=largest_first) + unknown


def by_share(joints: Iterable[str], numbers: Mapping[str, Mapping[str, float]]) -> list[str]:
    """Names of joints, the one that holds most of the squared error first."""
    return sorted(joints, key=lambda joint: -numbers[joint]["share"])


def _asset(folder: str, name: str) -> Markup:
    return Markup((files("t2l.report") / folder / name).read_text())
