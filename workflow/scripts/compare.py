"""Simulate the recordings with a model and write where it fails."""

from pathlib import Path

from t2l.diagnose.compare import compare, write
from t2l.diagnose.recordings_and_model import read_recordings_and_model
from t2l.jobs import job

with job(snakemake):
    section = snakemake.params.diagnosis
    model_path = snakemake.input.get("model") or section.get("model")
    model, recordings, holdout = read_recordings_and_model(
        [Path(path) for path in section["recordings"]],
        [Path(path) for path in section.get("holdout", [])],
        model_path and Path(model_path),
        [Path(path) for path in section.get("effects", [])],
    )
    write(compare(model, [*recordings, *holdout]), Path(snakemake.output.comparison).parent)
