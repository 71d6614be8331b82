"""The policies of each cell, one a training seed, and their rollouts.

Variants that are trained on the same data share them, and those that are trained alike share their
policies: the first of them has both.
"""

# Snakemake does not miss an intermediate artefact while what follows from it is there. Targets ask
# for every one, so that a deleted one is made again.
EVERY_CELL = [
    *expand(
        of_cell("{artefact}"),
        task=COLLECTIONS,
        variant={like(name, *LABELS) for name in VARIANTS},
        cell=CELLS,
        artefact=["episodes.parquet", "replays.parquet"],
    ),
    *expand(
        of_clone("{artefact}"),
        task=COLLECTIONS,
        variant={like(name, *TRAINED) for name in VARIANTS},
        cell=CELLS,
        seed=SEEDS,
        artefact=["policy.safetensors", "losses.parquet"],
    ),
    *expand(
        of_clone("{artefact}"),
        task=COLLECTIONS,
        variant=VARIANTS,
        cell=CELLS,
        seed=SEEDS,
        artefact=["rollouts.parquet", "traces.parquet"],
    ),
]


# the jobs of both rules make the same files; a configuration has one of them
if not SIDE_BY_SIDE:

    rule train:
        input:
            episodes=by_cell("episodes.parquet"),
            pictures=pictures,
        output:
            policies=[of_clone("policy.safetensors")],
            losses=[of_clone("losses.parquet")],
        params:
            version=VERSION,
            task=task_parameters,
            observation=of_variant("observation"),
            actions=of_variant("actions"),
            seed=SEED,
            cells=lambda wildcards: [wildcards.cell],
            seeds=lambda wildcards: [int(wildcards.seed)],
            demonstrations=of_variant("demonstrations"),
            settings=of_variant("training"),
        log:
            result("logs", "train", "{task}_{variant}_{cell}_seed{seed}.log"),
        benchmark:
            result("benchmarks", "train", "{task}_{variant}_{cell}_seed{seed}.tsv")
        resources:
            mem_mb=memory,
        conda:
            "../envs/t2l.yaml"
        script:
            "../scripts/train.py"

else:

    rule train_side_by_side:
        input:
            episodes=lambda wildcards: expand(
                of_cell("episodes.parquet"),
                variant=like(wildcards.variant, *LABELS),
                cell=CELLS,
                allow_missing=True,
            ),
            pictures=pictures,
        output:
            policies=expand(
                of_clone("policy.safetensors"), cell=CELLS, seed=SEEDS, allow_missing=True
            ),
            losses=expand(
                of_clone("losses.parquet"), cell=CELLS, seed=SEEDS, allow_missing=True
            ),
        params:
            version=VERSION,
            task=task_parameters,
            observation=of_variant("observation"),
            actions=of_variant("actions"),
            seed=SEED,
            cells=CELLS,
            seeds=SEEDS,
            demonstrations=of_variant("demonstrations"),
            settings=of_variant("training"),
        log:
            result("logs", "train_side_by_side", "{task}_{variant}.log"),
        benchmark:
            result("benchmarks", "train_side_by_side", "{task}_{variant}.tsv")
        resources:
            mem_mb=memory_side_by_side,
            gpu=1,
        conda:
            "../envs/t2l.yaml"
        script:
            "../scripts/train.py"


rule roll_out:
    input:
        policy=by_clone("policy.safetensors"),
    output:
        rollouts=of_clone("rollouts.parquet"),
        traces=of_clone("traces.parquet"),
    params:
        version=VERSION,
        task=task_parameters,
        observation=of_variant("observation"),
        actions=of_variant("actions"),
        seed=SEED,
        decimation=of_variant("decimation"),
        settings=of_variant("rollouts"),
    log:
        result("logs", "roll_out", "{task}_{variant}_{cell}_seed{seed}.log"),
    benchmark:
        result("benchmarks", "roll_out", "{task}_{variant}_{cell}_seed{seed}.tsv")
    resources:
        mem_mb=2000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/roll_out.py"
