"""The command `t2l explain` and the rules of the workflow are two ways to the same numbers."""

import json
import runpy
import shutil
from types import SimpleNamespace

import pytest

from t2l.cli.main import main
from t2l.identify.model import Model, read_model
from t2l.identify.step_size import substeps_for
from t2l.recordings import write_recording
from t2l.recordings.log import read_recordings
from tests.conftest import ROOT
from tests.diagnose.made import pendulum, swings

FRICTION = {"coulomb_friction": {"torque": {"hinge": 0.05}}}


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    """Recordings that `t2l explain` has explained."""
    home = tmp_path_factory.mktemp("home")
    logs = swings(pendulum(home), FRICTION, duration_s=0.5, substeps=8, control_rate_hz=125.0)
    for made in logs:
        write_recording(made, home / "logs" / made.name)
    main(["explain", str(home / "logs"), "--out", str(home / "by_command")])
    return home


def script(name, home, output, **files):
    """Run a script of the workflow as Snakemake does."""
    job = SimpleNamespace(
        log=[str(home / "said" / f"{name}.log")],
        config={},
        params=SimpleNamespace(diagnosis={"recordings": [str(home / "logs")]}),
        input=files,
        output=output,
    )
    runpy.run_path(str(ROOT / f"workflow/scripts/{name}.py"), {"snakemake": job})


def content(path):
    return json.loads(path.read_text())


def test_the_adopted_model_needs_finer_steps_than_the_one_before(home):
    """Else the others would prove little."""
    recordings = read_recordings([home / "logs"])
    after = read_model(home / "by_command" / "model.yaml")
    assert substeps_for(Model(after.robot), recordings) < substeps_for(after, recordings)


@pytest.mark.parametrize("which", ["before", "after"])
def test_a_comparison_is_the_same_by_command_and_by_rule(home, which):
    by_command = home / "by_command"
    folder = home / "by_rule" / which
    folder.mkdir(parents=True)
    model = {"model": str(by_command / "model.yaml")} if which == "after" else {}
    output = SimpleNamespace(comparison=str(folder / "comparison.json"))
    script("compare", home, output, **model)
    expected = content(by_command / which / "comparison.json")
    assert content(folder / "comparison.json") == expected
    given = ["--model", model["model"]] if model else []
    main(["compare", str(home / "logs"), *given, "--out", str(home / "compared" / which)])
    assert content(home / "compared" / which / "comparison.json") == expected


def test_an_explanation_is_the_same_by_command_and_by_rule(home, capsys):
    folder = home / "by_rule"
    shutil.copytree(home / "by_command" / "steps", folder / "steps")
    script("explain", home, SimpleNamespace(explanation=str(folder / "explanation.json")))
    # it took the command's steps for its own
    assert "Going on after step" in capsys.readouterr().out
    assert content(folder / "explanation.json") == content(home / "by_command/explanation.json")
