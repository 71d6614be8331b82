"""Simulate the recordings with a model and write where it fails."""

from pathlib import Path

from t2l.diagnose.compare import compare, write
from t2l.diagnose.inputs import read_together
from t2l.identify.step_size import substeps_for
from t2l.jobs import job

with job(snakemake):
    section = snakemake.params.diagnosis
    model_path = snakemake.input.get("model") or section.get("model")
    model, recordings, holdout = read_together(
        [Path(path) for path in section["recordings"]],
        [Path(path) for path in section.get("holdout", [])],
        model_path and Path(model_path),
        [Path(path) for path in section.get("effects", [])],
    )
    comparison = compare(model, [*recordings, *holdout], substeps_for(model, recordings))
    write(comparison, Path(snakemake.output.comparison).parent)
