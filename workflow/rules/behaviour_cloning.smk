"""A policy per cell, and its rollouts."""

# Snakemake does not miss an intermediate artefact while what follows from it is there. Targets ask
# for every one, so that a deleted one is made again.
EVERY_CELL = expand(
    of_cell("{artefact}"),
    task=TASKS,
    cell=CELLS,
    artefact=[
        "demonstrations",
        "replays.parquet",
        "policy.safetensors",
        "losses.parquet",
        "rollouts.parquet",
        "traces.parquet",
    ],
)


rule train:
    input:
        demonstrations=of_cell("demonstrations"),
    output:
        policy=of_cell("policy.safetensors"),
        losses=of_cell("losses.parquet"),
    params:
        version=VERSION,
        task=task_parameters,
        actions=STUDY.sections["actions"],
        seed=SEED,
        settings=STUDY.sections["training"],
    log:
        result("logs", "train", "{task}_{cell}.log"),
    benchmark:
        result("benchmarks", "train", "{task}_{cell}.tsv")
    resources:
        mem_mb=2000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/train.py"


rule roll_out:
    input:
        policy=of_cell("policy.safetensors"),
    output:
        rollouts=of_cell("rollouts.parquet"),
        traces=of_cell("traces.parquet"),
    params:
        version=VERSION,
        task=task_parameters,
        actions=STUDY.sections["actions"],
        seed=SEED,
        decimation=STUDY.decimation,
        settings=STUDY.sections["rollouts"],
    log:
        result("logs", "roll_out", "{task}_{cell}.log"),
    benchmark:
        result("benchmarks", "roll_out", "{task}_{cell}.tsv")
    resources:
        mem_mb=2000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/roll_out.py"
