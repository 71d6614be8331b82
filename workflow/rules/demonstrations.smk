"""Demonstrations, their retargeting to each cell, and how faithful that is."""

# demonstrated in each cell; in all others the expert's demonstrations are retargeted
OPERATED = [name for name, variant in VARIANTS.items() if variant["operator"]]

# for training with lerobot; nothing here needs them
DATASETS = expand(
    of_cell("demonstrations"),
    task=COLLECTIONS,
    variant={like(name, *LABELS, "observation") for name in VARIANTS},
    cell=CELLS,
)


rule demonstrate:
    output:
        demonstrations=directory(DEMONSTRATIONS),
    params:
        version=VERSION,
        task=task_parameters,
        seed=SEED,
        settings={k: v for k, v in STUDY.sections["demonstrations"].items() if k != "used"},
    log:
        result("logs", "demonstrate", "{task}.log"),
    benchmark:
        result("benchmarks", "demonstrate", "{task}.tsv")
    # all of behaviour cloning waits for it
    priority: 1
    threads: 2
    resources:
        mem_mb=2000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/demonstrate.py"


rule render:
    input:
        demonstrations=DEMONSTRATIONS,
    output:
        pictures=directory(result("{task}", "{variant}", "pictures")),
    params:
        version=VERSION,
        task=task_parameters,
        observation=of_variant("observation"),
        decimation=of_variant("decimation"),
        settings=of_variant("retargeting"),
    log:
        result("logs", "render", "{task}_{variant}.log"),
    benchmark:
        result("benchmarks", "render", "{task}_{variant}.tsv")
    # every training with pictures waits for it
    priority: 1
    resources:
        mem_mb=memory,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/render.py"


rule retarget:
    input:
        demonstrations=DEMONSTRATIONS,
    output:
        episodes=of_cell("episodes.parquet"),
        replays=of_cell("replays.parquet"),
    params:
        version=VERSION,
        task=task_parameters,
        actions=of_variant("actions"),
        decimation=of_variant("decimation"),
        settings=of_variant("retargeting"),
    wildcard_constraints:
        variant=one_of(set(VARIANTS) - set(OPERATED)),
    log:
        result("logs", "retarget", "{task}_{variant}_{cell}.log"),
    benchmark:
        result("benchmarks", "retarget", "{task}_{variant}_{cell}.tsv")
    resources:
        mem_mb=2000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/retarget.py"


rule collect:
    output:
        episodes=of_cell("episodes.parquet"),
        replays=of_cell("replays.parquet"),
    params:
        version=VERSION,
        task=task_parameters,
        seed=SEED,
        actions=of_variant("actions"),
        decimation=of_variant("decimation"),
        wanted={k: v for k, v in STUDY.sections["demonstrations"].items() if k != "used"},
        operator=of_variant("operator"),
    wildcard_constraints:
        variant=one_of(OPERATED),
    log:
        result("logs", "collect", "{task}_{variant}_{cell}.log"),
    benchmark:
        result("benchmarks", "collect", "{task}_{variant}_{cell}.tsv")
    resources:
        mem_mb=2000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/collect.py"


rule dataset:
    input:
        episodes=by_cell("episodes.parquet"),
        pictures=pictures,
    output:
        directory(of_cell("demonstrations")),
    params:
        version=VERSION,
        task=task_parameters,
        observation=of_variant("observation"),
        actions=of_variant("actions"),
        settings=of_variant("retargeting"),
    log:
        result("logs", "dataset", "{task}_{variant}_{cell}.log"),
    benchmark:
        result("benchmarks", "dataset", "{task}_{variant}_{cell}.tsv")
    resources:
        mem_mb=memory,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/dataset.py"


rule fidelity:
    input:
        demonstrations=DEMONSTRATIONS,
    output:
        result("{task}", "fidelity", "{cell}.parquet"),
    params:
        version=VERSION,
        task=task_parameters,
        actions=STUDY.sections["actions"],
        decimations=STUDY.sections["fidelity"]["decimations"],
        replays=STUDY.sections["fidelity"]["replays"],
    log:
        result("logs", "fidelity", "{task}_{cell}.log"),
    benchmark:
        result("benchmarks", "fidelity", "{task}_{cell}.tsv")
    resources:
        mem_mb=2000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/fidelity.py"
