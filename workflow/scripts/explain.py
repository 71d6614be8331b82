"""Add effects to the model until nothing more is justified."""

from pathlib import Path

from t2l.detective.data_split import split
from t2l.detective.explanation import explained
from t2l.diagnose.recordings_and_model import check_worth_fitting, read_recordings_and_model
from t2l.identify.progress import forward
from t2l.identify.step_size import substeps_for
from t2l.jobs import job

with job(snakemake):
    section = snakemake.params.diagnosis
    model, recordings, holdout = read_recordings_and_model(
        [Path(path) for path in section["recordings"]],
        [Path(path) for path in section.get("holdout", [])],
        section.get("model") and Path(section["model"]),
        [Path(path) for path in section.get("effects", [])],
    )
    check_worth_fitting(model, recordings, holdout)
    data = split(model.robot, recordings, holdout, substeps_for(model, recordings))
    folder = Path(snakemake.output.explanation).parent
    report = lambda what, fraction: print(f"{100 * fraction:3.0f} %  {what}", flush=True)  # noqa: E731
    tell = lambda said: print(said, flush=True)  # noqa: E731
    explained(model, data, tell, forward(report), folder=folder)
