"""From cells to one table per task, and to the study's table."""

TABLES = multiext(result("tables", "behaviour_cloning"), ".csv", ".md", ".tex")


rule summarise:
    input:
        replays=expand(of_cell("replays.parquet"), cell=CELLS, allow_missing=True),
        losses=expand(of_cell("losses.parquet"), cell=CELLS, allow_missing=True),
        rollouts=expand(of_cell("rollouts.parquet"), cell=CELLS, allow_missing=True),
    output:
        rollouts=result("{task}", "rollouts.parquet"),
        cells=result("{task}", "cells.parquet"),
    params:
        version=VERSION,
        cells=CELLS,
    log:
        result("logs", "summarise", "{task}.log"),
    benchmark:
        result("benchmarks", "summarise", "{task}.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/summarise.py"


rule statistics:
    input:
        rollouts=expand(result("{task}", "rollouts.parquet"), task=TASKS),
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
