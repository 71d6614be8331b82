#!/usr/bin/env bash
# Run by Snakemake, in the folder of the project, once the conda environment exists.
set -euo pipefail
python=$CONDA_PREFIX/bin/python
uv pip install --python "$python" --require-hashes -r environment.lock
uv pip install --python "$python" --no-deps --no-build-isolation --editable .
