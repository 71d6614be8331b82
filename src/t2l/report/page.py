"""The page itself: one HTML file that needs nothing but a browser."""

import json
from html import escape
from importlib.resources import files
from pathlib import Path

from plotly.offline import get_plotlyjs

from t2l.artefacts import write_text
from t2l.diagnose.results import Found, read_found
from t2l.figures.style import COLOURS
from t2l.report import sections
from t2l.report.payload import payload

NAME = "report.html"

_PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; \
script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:">
<title>{title}</title>
<link rel="icon" href="data:,">
<style>{style}</style>
</head>
<body data-plots-drawn="0" data-errors="0">
<main>
{body}
</main>
<script type="application/json" id="data">{data}</script>
<script>{plotly}</script>
<script>{script}</script>
</body>
</html>
"""


def write_report(folder: Path | str) -> Path:
    """Write ``report.html`` into a folder that `t2l compare`, `diagnose` or `explain` filled.

    Raises:
        ArtefactError: the folder holds none of their results, or a malformed one.
    """
    path = Path(folder) / NAME
    write_text(render(read_found(folder)), path)
    return path


def render(found: Found) -> str:
    """The page as HTML."""
    title, parts = sections.tell(found)
    data = payload(found) | {"colours": COLOURS}
    return _PAGE.format(
        title=escape(title),
        style=_asset("page.css"),
        body="\n".join(parts),
        # "<" could end the script element
        data=json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c"),
        plotly=get_plotlyjs(),
        script=_asset("page.js"),
    )


def _asset(name: str) -> str:
    return files("t2l.report").joinpath(name).read_text()
