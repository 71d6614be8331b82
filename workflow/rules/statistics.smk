"""From cells to one table per task, and to the study's table."""

from t2l.study.published.grids import COUNTERPARTS

REGIONS = [
    *multiext(result("tables", "regions"), ".csv", ".md", ".tex"),
    *expand(result("figures", "regions.{suffix}"), suffix=FORMATS),
]
# one file or none
PUBLISHED = list(filter(None, [STUDY.sections["attenuation"].get("published_grids")]))
# tasks that the study has published grids of
COMPARED = {task: STUDY.tasks[task]["kind"] for task in TASKS} if PUBLISHED else {}
COMPARED = {task: kind for task, kind in COMPARED.items() if kind in COUNTERPARTS}
# one variant for each number of demonstrations, the same in every cell
SIZES = {
    next(iter(numbers)): name
    for name, variant in reversed(VARIANTS.items())
    if but_for_demonstrations(variant) == but_for_demonstrations(VARIANTS[NOMINAL])
    if len(numbers := set(trained_on(name).values())) == 1
}
# two would fit any line
SIZED = [SIZES[number] for number in sorted(SIZES)] if len(SIZES) >= 3 else []
SCALING = [
    *multiext(result("tables", "scaling"), ".csv", ".md", ".tex"),
    *expand(result("figures", "scaling.{suffix}"), suffix=FORMATS),
] if SIZED else []
# of one collection there is nothing to compare
ANEW = [
    *multiext(result("tables", "collections"), ".csv", ".md", ".tex"),
    *expand(result("figures", "collections.{suffix}"), suffix=FORMATS),
] if len(COLLECTIONS) > len(TASKS) else []
TABLES = [
    *multiext(result("tables", "behaviour_cloning"), ".csv", ".md", ".tex"),
    *ANEW[:3],
    *REGIONS[:3],
    *SCALING[:3],
    *(multiext(result("tables", "published_grids"), ".csv", ".md", ".tex") if COMPARED else []),
]


rule summarise:
    input:
        replays=lambda wildcards: expand(
            of_cell("replays.parquet"),
            variant=like(wildcards.variant, *LABELS),
            cell=CELLS,
            allow_missing=True,
        ),
        losses=lambda wildcards: expand(
            of_clone("losses.parquet"),
            variant=like(wildcards.variant, *TRAINED),
            cell=CELLS,
            seed=SEEDS,
            allow_missing=True,
        ),
        rollouts=expand(
            of_clone("rollouts.parquet"), cell=CELLS, seed=SEEDS, allow_missing=True
        ),
    output:
        rollouts=result("{task}", "{variant}", "rollouts.parquet"),
        cells=result("{task}", "{variant}", "cells.parquet"),
    params:
        version=VERSION,
        seeds=SEEDS,
        demonstrations=lambda wildcards: trained_on(wildcards.variant),
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
        cells=expand(result("{task}", NOMINAL, "cells.parquet"), task=TASKS),
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


rule regions:
    input:
        expand(
            result("{task}", "{variant}", "cells.parquet"), task=TASKS, variant=VARIANTS
        ),
    output:
        table=study_table("regions"),
        figure=study_figure("regions"),
    params:
        version=VERSION,
        # with several tasks a variant's name alone says too little
        names=[
            variant if len(TASKS) == 1 else f"{task} {variant}"
            for task in TASKS
            for variant in VARIANTS
        ],
        grid=STUDY.sections["grid"],
    log:
        result("logs", "regions.log"),
    benchmark:
        result("benchmarks", "regions.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/regions.py"


rule collections:
    input:
        expand(
            result("{task}", "{variant}", "cells.parquet"),
            task=COLLECTIONS,
            variant=VARIANTS,
        ),
    output:
        table=study_table("collections"),
        figure=study_figure("collections"),
    params:
        version=VERSION,
        # of each table in turn: what it is compared as, and the collection
        of=[
            (variant if len(TASKS) == 1 else f"{task} {variant}", number)
            for task in TASKS
            for number in range(STUDY.sections["collections"])
            for variant in VARIANTS
        ],
        grid=STUDY.sections["grid"],
    log:
        result("logs", "collections.log"),
    benchmark:
        result("benchmarks", "collections.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/collections.py"


rule scaling:
    input:
        **{
            task: expand(result(task, "{variant}", "cells.parquet"), variant=SIZED)
            for task in TASKS
        },
    output:
        table=study_table("scaling"),
        figure=study_figure("scaling"),
    params:
        version=VERSION,
        tasks=TASKS,
        grid=STUDY.sections["grid"],
    log:
        result("logs", "scaling.log"),
    benchmark:
        result("benchmarks", "scaling.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/scaling.py"


rule published_grids:
    input:
        cells=expand(result("{task}", NOMINAL, "cells.parquet"), task=COMPARED),
        published=PUBLISHED,
    output:
        study_table("published_grids"),
    params:
        version=VERSION,
        kinds=COMPARED,
    log:
        result("logs", "published_grids.log"),
    benchmark:
        result("benchmarks", "published_grids.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/published_grids.py"
