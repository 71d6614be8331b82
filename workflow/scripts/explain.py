"""Add effects to the model until nothing more is justified."""

from pathlib import Path

from t2l.diagnose.evidence import gather
from t2l.diagnose.forward_selection import explain, write_explanation
from t2l.diagnose.recordings_and_model import read_recordings_and_model
from t2l.identify.loop_stability import check_settles
from t2l.identify.step_size import substeps_for
from t2l.jobs import job
from t2l.propose.beside import proposed_beside

with job(snakemake):
    section = snakemake.params.diagnosis
    model, recordings, holdout = read_recordings_and_model(
        [Path(path) for path in section["recordings"]],
        [Path(path) for path in section.get("holdout", [])],
        section.get("model") and Path(section["model"]),
        [Path(path) for path in section.get("effects", [])],
    )
    check_settles(model, [*recordings, *holdout])
    evidence = gather(model.robot, recordings, holdout, substeps_for(model, recordings))
    folder = Path(snakemake.output.explanation).parent
    report = lambda what, fraction: print(f"{100 * fraction:3.0f} %  {what}", flush=True)  # noqa: E731
    explanation = explain(model, evidence, folder, report)
    explanation = proposed_beside(model, explanation, evidence, folder, report)
    write_explanation(explanation, folder)
