# Everything a person runs by hand; `make` alone lists it.
ENV := .venv
BIN := $(ENV)/bin
CORES ?= 2
CONFIG ?= config/config.yaml
UV_VERSION := 0.13.8
# uv from PATH, else from PyPI into a private folder
UV := $(or $(shell command -v uv 2>/dev/null),.uv/bin/uv)
# with it, as containers set it, every process compiles its libraries anew: twice the time
unexport PYTHONDONTWRITEBYTECODE
SNAKEMAKE = $(BIN)/snakemake --cores $(CORES) --configfile $(CONFIG)

.PHONY: help figures tables diagnosis decoupling landscape learning published all report test test-slow lint bench docs lock clean

help:
	@echo "make figures   all figures of $(CONFIG) (another: make figures CONFIG=config/studies/paper.yaml)"
	@echo "make tables    all tables"
	@echo "make diagnosis compares a model with recordings, finds what it lacks"
	@echo "make decoupling CONFIG=config/studies/decoupling.yaml  stiffness against gains"
	@echo "make learning CONFIG=config/studies/lift_cube.yaml     tasks with contacts, learned in simulation alone"
	@echo "make landscape CONFIG=config/studies/landscape.yaml    how easily RL finds action scales"
	@echo "make all       figures, tables and diagnosis"
	@echo "make report    one HTML page with all of this: results/report.html"
	@echo "make test      lint and all tests but the slow ones"
	@echo "make test-slow those: smoke runs through Slurm and killed twenty times, the largest plan"
	@echo "make bench     speed, as ratios against baselines of the same run"
	@echo "make published the scoreboard, tables and figures of docs/, of kept results; trains nothing"
	@echo "make docs      write config/schema.json, the table of config/README.md, scoreboard and figures anew"
	@echo "make lock      compile environment.lock anew from pyproject.toml"
	@echo "make clean     remove the environment; results stay"

figures tables diagnosis decoupling landscape learning published all: $(ENV)/ready
	$(SNAKEMAKE) -- $@

report: all
	$(SNAKEMAKE) --report results/report.html -- all

test: $(ENV)/ready lint
	$(BIN)/python -m pytest

test-slow: $(ENV)/ready
	$(BIN)/python -m pytest -m slow

lint: $(ENV)/ready
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/snakemake --lint

bench: $(ENV)/ready
	$(BIN)/python -m benchmarks

docs: $(ENV)/ready
	$(BIN)/python -m t2l.config.document
	$(BIN)/python -m t2l.report.kept

lock: | $(UV)
	$(UV) pip compile --quiet --universal --generate-hashes --python-version 3.12 --all-extras \
		pyproject.toml -o environment.lock

clean:
	rm -rf $(ENV) .uv

# A half-made environment has no `ready`, so an interrupted install is done again.
$(ENV)/ready: environment.lock pyproject.toml src/lerobot_env_t2l/pyproject.toml Makefile | $(UV)
	$(UV) venv --quiet --clear --python 3.12 $(ENV)
	$(UV) pip sync --quiet --python $(BIN)/python --require-hashes environment.lock
	$(UV) pip install --quiet --python $(BIN)/python --no-deps --no-build-isolation --editable . \
		./src/lerobot_env_t2l
	touch $@

.uv/bin/uv:
	python3 -m pip install --quiet --disable-pip-version-check --target .uv uv==$(UV_VERSION) \
		|| { python3 -m venv .uv && .uv/bin/python -m pip install --quiet uv==$(UV_VERSION); }
