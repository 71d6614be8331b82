"""Gains and action scale searched together, as `t2l tune` does."""

from t2l.config.watched import watched

GAIN_SEARCHES = {entry["task"]: entry for entry in LEARNING.get("gain_searches", [])}


wildcard_constraints:
    searched="|".join(GAIN_SEARCHES) or "none",


# A worker runs trials until the search has enough; several of them share it. The trials are in
# Optuna's journal, which outlives a job that was cut short.
rule search_gains:
    input:
        lambda wildcards: watched(GAIN_SEARCHES[wildcards.searched]),
    output:
        of_gain_search("worker_{worker}.txt"),
    params:
        version=VERSION,
        entry=lambda wildcards: GAIN_SEARCHES[wildcards.searched],
        task=lambda wildcards: dict(STUDY.tasks[wildcards.searched]),
        settings=TRAINING_SETTINGS,
        storage=TUNING["storage"],
    threads: 1
    log:
        result("logs", "search_gains", "{searched}_{worker}.log"),
    benchmark:
        result("benchmarks", "search_gains", "{searched}_{worker}.tsv")
    resources:
        mem_mb=2000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/search_gains.py"


rule gain_front:
    input:
        lambda wildcards: expand(
            of_gain_search("worker_{worker}.txt"),
            searched=wildcards.searched,
            worker=range(GAIN_SEARCHES[wildcards.searched]["workers"]),
        ),
    output:
        trials=of_gain_search("trials.csv"),
        front=captioned(
            of_gain_search("front.csv"),
            "../report/gain_front_table.rst",
            "Learning in simulation",
        ),
        figure=[
            of_gain_search("figures/front.pdf"),
            captioned(
                of_gain_search("figures/front.png"),
                "../report/gain_front.rst",
                "Learning in simulation",
            ),
        ],
    params:
        version=VERSION,
        entry=lambda wildcards: GAIN_SEARCHES[wildcards.searched],
        task=lambda wildcards: dict(STUDY.tasks[wildcards.searched]),
        settings=TRAINING_SETTINGS,
        storage=TUNING["storage"],
    threads: 1
    log:
        result("logs", "gain_front", "{searched}.log"),
    benchmark:
        result("benchmarks", "gain_front", "{searched}.tsv")
    resources:
        mem_mb=2000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/gain_front.py"


GAIN_FRONTS = expand(of_gain_search("front.csv"), searched=GAIN_SEARCHES)
LEARNING_RESULTS += GAIN_FRONTS
