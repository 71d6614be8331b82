"""From cells to one table per task, and to the study's table."""

TABLES = multiext(result("tables", "behaviour_cloning"), ".csv", ".md", ".tex")


rule summarise:
    input:
        replays=lambda wildcards: expand(
            of_cell("replays.parquet"),
            variant=like(wildcards.variant, *LABELS),
            cell=CELLS,
            allow_missing=True,
        ),
        losses=lambda wildcards: expand(
            of_policy("losses.parquet"),
            variant=like(wildcards.variant, *TRAINED),
            cell=CELLS,
            seed=SEEDS,
            allow_missing=True,
        ),
        rollouts=expand(
            of_policy("rollouts.parquet"), cell=CELLS, seed=SEEDS, allow_missing=True
        ),
    output:
        rollouts=result("{task}", "{variant}", "rollouts.parquet"),
        cells=result("{task}", "{variant}", "cells.parquet"),
    params:
        version=VERSION,
        seeds=SEEDS,
    log:
        result("logs", "summarise", "{task}_{variant}.log"),
    benchmark:
        result("benchmarks", "summarise", "{task}_{variant}.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/summarise.py"


rule statistics:
    input:
        rollouts=expand(result("{task}", NOMINAL, "rollouts.parquet"), task=TASKS),
    output:
        csv=captioned(TABLES[0], "../report/table.rst"),
        markdown=TABLES[1],
        latex=TABLES[2],
    params:
        version=VERSION,
        tasks=TASKS,
        grid=STUDY.sections["grid"],
    log:
        result("logs", "statistics.log"),
    benchmark:
        result("benchmarks", "statistics.tsv")
    resources:
        mem_mb=2000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/behaviour_cloning_table.py"
