"""What a proposal leaves in a folder, and how it is adopted."""

import json

import numpy as np
import pytest

from t2l.cli.inputs import check_without
from t2l.cli.main import main
from t2l.effects.law import TORQUE, Curve, Law
from t2l.errors import ArtefactError, ConfigurationError
from t2l.identify.model import Model, read_model
from t2l.identify.prediction import Predictor
from t2l.propose import formula as formulas
from t2l.propose.artefacts import proposed, write_proposal
from t2l.propose.proposal import LAW, Learned, Proposal, error_of
from t2l.report import write_report
from tests.diagnose.made import pendulum, swings

AT = np.linspace(-1.0, 1.5, 30)
NAME = "torque_hinge_position"


def made(folder, until_s=np.inf):
    """A folder with a spring's curve, the proposal, and the samples it was learned from.

    The first samples report.
    """
    robot = pendulum(folder)
    law = Law(TORQUE, "hinge", "position", "hinge")
    curve = Curve(law, tuple(AT.tolist()), tuple((-0.1 * AT).tolist()))
    model = Model(robot)
    recordings = swings(robot, duration_s=0.6, model=Model(robot, learned=(curve,)))
    predictor = Predictor(robot, recordings, threads=1)
    learned = Learned(curve, np.array(curve.torque) - 3e-3, np.array(curve.torque) + 3e-3)
    proposal = Proposal(
        LAW, model, ("hinge",), (learned,), 1e-4, 2e-3, 1e-4, None, None, (), ("a", "b"), ()
    )
    chosen = predictor, np.ones(len(predictor.samples), bool)
    reports = predictor.samples.time < until_s
    write_proposal(proposal, folder / "out", [chosen], predictor, report_mask=reports)
    return folder / "out", predictor


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return made(tmp_path_factory.mktemp("proposal"))


def test_the_curve_and_its_formula_are_adopted(folder, tmp_path, monkeypatch):
    out, predictor = folder
    monkeypatch.chdir(tmp_path)
    kinds = ["learned", "formula"] if formulas.installed() else ["learned"]
    assert proposed(out) == [f"{kind}_{NAME}" for kind in kinds]
    for kind in kinds:
        main(["adopt", f"{kind}_{NAME}", "--diagnosis", str(out), "--out", f"{kind}.yaml"])
        model = read_model(tmp_path / f"{kind}.yaml")
        assert error_of(model, predictor) == pytest.approx(1e-4, rel=0.2)


def test_the_page_shows_the_curve(folder):
    out, _ = folder
    text = write_report(out).read_text()
    assert "a torque on hinge that falls with its position" in text
    assert 'data-plot="curve"' in text


@pytest.mark.skipif(not formulas.installed(), reason="pyoperon is not installed")
def test_a_formula_is_reported_on_the_samples_that_report(tmp_path):
    out, predictor = made(tmp_path, until_s=0.3)
    content = json.loads((out / "proposal.json").read_text())
    model, early = read_model(out / "models" / f"formula_{NAME}.yaml"), predictor.samples.time < 0.3
    left = error_of(model, predictor, early)
    assert left != pytest.approx(error_of(model, predictor), rel=1e-3)
    # a file has rounded numbers
    assert content["report"]["formulas_rmse_q_rad"] == pytest.approx(left, rel=1e-4)
    assert content["curves"][0]["formula"]["report_rmse_q_rad"] == pytest.approx(left, rel=1e-4)


def test_without_the_library_it_is_said(tmp_path, monkeypatch):
    monkeypatch.setattr(formulas, "find_spec", lambda name: None)
    out, _ = made(tmp_path)
    (curve,) = json.loads((out / "proposal.json").read_text())["curves"]
    assert curve["formula"] is None
    assert "t2l[propose]" in curve["note"]


def test_an_earlier_proposal_is_removed(tmp_path):
    out, predictor = made(tmp_path)
    chosen = predictor, np.ones(len(predictor.samples), bool)
    empty = Proposal(
        "no_law", Model(predictor.robot), ("hinge",), (), 1e-4, 1e-3, 1e-3, None, None, (), (), ()
    )
    write_proposal(empty, out, [chosen])
    assert proposed(out) == []
    assert not [path for path in out.rglob("*") if path.suffix in (".yaml", ".py")]


@pytest.mark.parametrize("text", ["{", "[]", '{"curves": 3}', '{"curves": [{}]}'])
def test_a_broken_proposal_is_told(tmp_path, text):
    (tmp_path / "proposal.json").write_text(text)
    with pytest.raises(ArtefactError, match=r"proposal\.json"):
        proposed(tmp_path)
    with pytest.raises(ArtefactError, match=r"proposal\.json"):
        write_report(tmp_path)


def test_only_a_known_effect_can_be_left_out(folder):
    _, predictor = folder
    model = Model(predictor.robot, {"torque_offset": {"torque": {"hinge": 0.1}}})
    assert "cogging" not in Model(predictor.robot, without=("cogging",)).known_effects()
    for name in ("magic", "torque_offset"):
        with pytest.raises(ConfigurationError, match=f"--without: found '{name}'"):
            check_without([name], model)
