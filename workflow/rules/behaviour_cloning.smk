"""A policy per cell, and its rollouts."""


rule train:
    input:
        demonstrations=CELL + "/demonstrations",
    output:
        policy=CELL + "/policy.safetensors",
        losses=CELL + "/losses.parquet",
    params:
        task=task_parameters,
        seed=SEED,
        settings=STUDY.sections["training"],
    log:
        result("logs", "train", "{task}_{cell}.log"),
    benchmark:
        result("benchmarks", "train", "{task}_{cell}.tsv")
    resources:
        mem_mb=2000,
    script:
        "../scripts/train.py"


rule roll_out:
    input:
        policy=CELL + "/policy.safetensors",
    output:
        rollouts=CELL + "/rollouts.parquet",
        traces=CELL + "/traces.parquet",
    params:
        task=task_parameters,
        seed=SEED,
        decimation=STUDY.decimation,
        settings=STUDY.sections["rollouts"],
    log:
        result("logs", "roll_out", "{task}_{cell}.log"),
    benchmark:
        result("benchmarks", "roll_out", "{task}_{cell}.tsv")
    resources:
        mem_mb=2000,
    script:
        "../scripts/roll_out.py"
