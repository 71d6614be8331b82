"""What the pages name exists: keys, links, commands, options, targets, layers, files to cite by."""

import importlib.util
import io
import re
import shlex
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from contextlib import redirect_stdout, suppress
from functools import cache
from pathlib import Path

import pytest
import yaml

from t2l.cli import main as cli
from t2l.effects.registry import builtin
from t2l.tasks import TASKS
from tests.conftest import ROOT
from tests.test_layers import LAYERS

MOST_README_LINES = 130
PAGES = sorted(
    [*ROOT.glob("*.md"), *ROOT.glob("docs/*.md"), *ROOT.glob("config/*.md")],
    key=lambda page: str(page),
)
OPTION = re.compile(r"(?<![\w-])--[a-z][a-z-]*")
# options of tools that no page explains: pytest with Hypothesis
OF_OTHERS = {"--config", "--hypothesis-profile"}

each_page = pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))


@pytest.mark.parametrize("task", TASKS.names())
def test_every_key_of_a_task_is_explained(task):
    text = (ROOT / "config/README.md").read_text().split("## Task files")[1]
    explained = set(re.findall(r"`([a-z_]+)`", text))
    missing = set(TASKS.find(task).parameters.model_fields) - explained
    assert not missing, f"{missing} stand in no table of config/README.md"


def test_every_study_is_listed_with_its_time():
    text = (ROOT / "config/README.md").read_text()
    missing = [
        p.stem for p in ROOT.glob("config/studies/*.yaml") if f"`studies/{p.name}`" not in text
    ]
    assert not missing, f"{missing} stand in no table of config/README.md"


def _code_lines(text: str) -> Iterator[str]:
    """Lines of code blocks, indented or fenced."""
    fenced = False
    for line in text.splitlines():
        if line.startswith("```"):
            fenced = not fenced
        elif fenced or line.startswith("    "):
            yield line.strip()


def _without_code(text: str) -> str:
    lines, fenced = [], False
    for line in text.splitlines():
        if line.startswith("```"):
            fenced = not fenced
        elif not fenced and not line.startswith("    "):
            lines.append(line)
    return re.sub(r"`[^`]*`", lambda code: "_" * len(code[0]), "\n".join(lines))


def _spans(text: str) -> list[str]:
    """What stands between single backticks."""
    fences = re.sub(r"^```.*?^```$", "", text, flags=re.M | re.S)
    return re.findall(r"`([^`\n]+)`", fences)


def _commands(page: Path, program: str) -> list[str]:
    """Lines of code blocks and spans of code that begin with `program`."""
    text = page.read_text()
    return [code for code in (*_code_lines(text), *_spans(text)) if code.split(" ")[0] == program]


def _headings(page: Path) -> set[str]:
    """As GitHub makes anchors of them."""
    text = re.sub(r"^```.*?^```$", "", page.read_text(), flags=re.M | re.S)
    titles = re.findall(r"^#+ (.+)$", text, flags=re.M)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


def test_the_readme_is_short():
    lines = (ROOT / "README.md").read_text().splitlines()
    assert len(lines) <= MOST_README_LINES


def test_every_page_is_reached_from_the_readme():
    reached = {(ROOT / link).resolve() for link, _ in _links(ROOT / "README.md")}
    assert set(PAGES) - reached == {ROOT / "README.md"}


def _links(page: Path) -> list[tuple[str, str]]:
    """Relative links: the path, empty within a page, and the anchor."""
    # what a link shows may be code, where it leads to is not
    links = re.findall(r"\]\(([^)\s]+)\)", _without_code(page.read_text()))
    relative = [link for link in links if not re.match(r"[a-z]+:", link)]
    return [(path, anchor) for path, _, anchor in (link.partition("#") for link in relative)]


@each_page
def test_links_lead_somewhere(page):
    for path, anchor in _links(page):
        target = (page.parent / path).resolve() if path else page
        assert target.exists(), path
        assert target.is_relative_to(ROOT), f"{path} leads out of the project"
        assert not anchor or anchor in _headings(target), f"{path}#{anchor}"


def test_every_picture_is_shown():
    shown = {(page.parent / path).resolve() for page in PAGES for path, _ in _links(page) if path}
    assert set((ROOT / "docs").glob("*.png")) <= shown


@cache
def _help(command: str) -> str:
    """What `t2l COMMAND --help` prints."""
    printed = io.StringIO()
    with redirect_stdout(printed), suppress(SystemExit):
        cli.main([command, "--help"])
    return printed.getvalue()


@each_page
def test_commands_and_options_exist(page, monkeypatch):
    taken = []
    for module in cli.COMMANDS.values():
        monkeypatch.setattr(module, "run", taken.append)
    for line in _commands(page, "t2l"):
        words = shlex.split(line, comments=True)[1:]
        # `t2l` alone, and `t2l COMMAND` as a placeholder
        command = words[0] if words else "COMMAND"
        if command == "COMMAND":
            assert not set(OPTION.findall(line)) - {"--help"}, line
            continue
        assert command in cli.COMMANDS, line
        unknown = set(OPTION.findall(line)) - set(OPTION.findall(_help(command)))
        assert not unknown, f"{line}: {unknown}"
        # a whole command line, not its name or a pattern of it
        if len(words) > 1 and not re.search(r"[…\[\]]", line):
            cli.main(words)
            assert taken.pop().command == command, line


@each_page
def test_options_named_alone_exist(page):
    alone = {option for span in _spans(page.read_text()) for option in OPTION.findall(span)
             if span.startswith("--")}  # fmt: skip
    alone -= OF_OTHERS
    known = {option for command in cli.COMMANDS for option in OPTION.findall(_help(command))}
    assert alone <= known, alone - known


def _make_targets() -> set[str]:
    text = (ROOT / "Makefile").read_text()
    variables = dict(re.findall(r"^(\w+) :?\??= *(\S+)$", text, flags=re.M))
    lines = re.findall(r"^([^\s#:=][^:=]*):(?!=)", text, flags=re.M)
    names = {name for line in lines for name in line.split()}
    return {re.sub(r"\$\((\w+)\)", lambda v: variables[v[1]], name) for name in names}


@each_page
def test_targets_of_make_exist(page):
    targets = _make_targets()
    assert {"figures", ".venv/ready"} <= targets
    for line in _commands(page, "make"):
        words = shlex.split(line, comments=True)[1:]
        settings = dict(word.split("=") for word in words if "=" in word)
        unknown = {word for word in words if "=" not in word} - targets
        assert not unknown, f"{line}: {unknown}"
        assert set(settings) <= {"CONFIG", "CORES"}, line
        assert (ROOT / settings.get("CONFIG", "")).exists(), line


@pytest.fixture(scope="module")
def snakemake_lines():
    """Every command line of Snakemake in the pages, and its arguments by Snakemake's parser."""
    from snakemake.cli import get_argument_parser

    parser = get_argument_parser()
    options = {option for action in parser._actions for option in action.option_strings}
    found = {}
    for page in PAGES:
        for line in _commands(page, "snakemake"):
            unknown = set(OPTION.findall(line)) - options
            assert not unknown, f"{line}: {unknown}"
            found[line] = parser.parse_args(shlex.split(line, comments=True)[1:])
    return found


def test_targets_of_snakemake_exist(snakemake_lines):
    # those of other configurations are not planned here
    lines = [parsed for parsed in snakemake_lines.values() if not parsed.configfile]
    targets = {target for parsed in lines for target in parsed.targets}
    assert {"figures", "diagnosis"} <= targets
    run = subprocess.run(
        [sys.executable, "-m", "snakemake", "-n", "--quiet", "--cores", "1", "--", *targets],
        cwd=ROOT, capture_output=True, text=True,
    )  # fmt: skip
    assert run.returncode == 0, run.stdout + run.stderr


def test_files_that_snakemake_is_given_exist(snakemake_lines):
    for line, parsed in snakemake_lines.items():
        for path in [*(parsed.configfile or []), *(parsed.profile or [])]:
            assert (ROOT / path).exists(), line


@each_page
def test_modules_that_are_run_exist(page):
    for line in re.findall(r"python -m ([\w. ]+)", page.read_text()):
        module, *names = line.split()
        assert importlib.util.find_spec(module), line
        if module == "benchmarks":
            for name in names:
                assert (ROOT / "benchmarks" / f"{name}.py").exists(), line


def test_the_readme_draws_the_layers():
    """A line each, as the test of imports has them."""
    lines = [line.split("  ")[0] for line in _code_lines((ROOT / "README.md").read_text())]
    for layer in LAYERS:
        assert " ".join(sorted(layer)) in lines


def test_every_effect_is_in_the_table():
    text = (ROOT / "docs/recordings.md").read_text()
    section = text.split("\n## Effects\n")[1].split("\n## ")[0]
    assert set(re.findall(r"^\| `(\w+)` \|", section, flags=re.M)) == set(builtin())


def test_the_software_can_be_cited():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert citation["cff-version"] == "1.2.0"
    assert citation["message"]
    assert citation["title"] == project["name"]
    assert citation["version"] == project["version"]
    assert citation["license"] == project["license"]
    assert citation["authors"] == [{"name": "The t2l authors"}]
    (study,) = citation["references"]
    assert study["type"]
    assert study["title"].startswith("Tune to Learn")
    assert [author["family-names"] for author in study["authors"]] == ["Bronars", "Park", "Agrawal"]


def test_the_licence_is_that_of_the_project():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    text = (ROOT / "LICENSE").read_text()
    assert project["license"] == "Apache-2.0"
    assert project["license-files"] == ["LICENSE"]
    assert "Apache License\n                           Version 2.0" in text
    assert "END OF TERMS AND CONDITIONS" in text
    assert re.search(r"Copyright \d{4} The t2l authors", text)


def rows_below(page, heading):
    """The cells of each row of a section's only table."""
    section = (ROOT / page).read_text().split(f"\n## {heading}\n")[1].split("\n## ")[0]
    lines = [line for line in section.splitlines() if line[:1] == "|"]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]


def test_verdicts_that_were_changed_are_those_of_the_scoreboard_now():
    now = {row[0]: row[-1] for row in rows_below("docs/scoreboard.md", "As it came out")}
    changed = rows_below("docs/scoreboard_rules.md", "Verdicts that were changed")
    assert changed
    for statement, before, verdict, _ in changed:
        assert before != verdict == now[statement]


@pytest.mark.parametrize("page", ["README.md", "docs/scoreboard.md"])
def test_the_counts_of_verdicts_are_those_of_the_scoreboard(page):
    verdicts = [row[-1] for row in rows_below("docs/scoreboard.md", "As it came out")]
    said = re.search(
        r"of (\d+) statements (\d+) are reproduced, (\d+) are not, (\d+) cannot be told, "
        r"(?:and )?(\d+) are (?:open|\[open\])",
        " ".join((ROOT / page).read_text().split()),
        re.IGNORECASE,
    )
    every, *counted = (int(number) for number in said.groups())
    shown = ("reproduced", "not reproduced", "cannot be told")
    assert counted[:3] == [verdicts.count(verdict) for verdict in shown]
    assert every == sum(counted)
