"""A page in a headless browser: what it makes of the page, and what it complains about."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--enable-logging=stderr",
    "--virtual-time-budget=60000",
)
# drawing in software, which takes the place of a GPU, is slow, and says so
WITHOUT_WEBGL = ("--disable-gpu", "--disable-3d-apis")
WITH_WEBGL = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
OF_THE_DRIVER = ("GL Driver Message", "software")


def browse(page: Path, folder: Path, script: str, webgl: bool = False) -> str:
    """The page's elements after `script`, which ends its body, has run; the test skips without one.

    Args:
        folder: for the page with the script, and the browser's own files.
        webgl: draw in three dimensions, in software.
    """
    browser = next((path for name in BROWSERS if (path := shutil.which(name))), None)
    if browser is None:
        pytest.skip(f"needs a browser: none of {', '.join(BROWSERS)} is on PATH")
    tried = folder / "tried.html"
    tried.write_text(page.read_text().replace("</body>", script))
    flags = (*FLAGS, *(WITH_WEBGL if webgl else WITHOUT_WEBGL))
    profile = f"--user-data-dir={folder / 'profile'}"
    command = [browser, *flags, profile, "--dump-dom", tried.as_uri()]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    said = [line for line in done.stderr.splitlines() if "CONSOLE" in line]
    if webgl:
        said = [line for line in said if not any(words in line for words in OF_THE_DRIVER)]
    assert not said
    return done.stdout


def data_of(dom: str, name: str) -> str | None:
    """An attribute data-NAME of the body."""
    found = re.search(rf'<body[^>]* data-{name}="([^"]*)"', dom)
    return found and found[1].replace("&quot;", '"')
