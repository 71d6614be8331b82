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


# a job trains one policy, or all of a variant
TRAINED_TOGETHER = {"cell": CELLS, "seed": SEEDS} if SIDE_BY_SIDE else {}
TRAIN, TRAIN_FILE = (
    ("train_side_by_side", "{task}_{variant}")
    if SIDE_BY_SIDE
    else ("train", "{task}_{variant}_{cell}_seed{seed}")
)


rule:
    name:
        TRAIN
    input:
        episodes=by_cell("episodes.parquet", **TRAINED_TOGETHER),
        pictures=pictures,
    output:
        policies=in_one_job(of_clone("policy.safetensors"), **TRAINED_TOGETHER),
        losses=in_one_job(of_clone("losses.parquet"), **TRAINED_TOGETHER),
    params:
        version=VERSION,
        task=task_parameters,
        observation=of_variant("observation"),
        actions=of_variant("actions"),
        seed=SEED,
        cells=CELLS if SIDE_BY_SIDE else lambda wildcards: [wildcards.cell],
        seeds=SEEDS if SIDE_BY_SIDE else lambda wildcards: [int(wildcards.seed)],
        demonstrations=of_variant("demonstrations"),
        settings=of_variant("training"),
    log:
        result("logs", TRAIN, f"{TRAIN_FILE}.log"),
    benchmark:
        result("benchmarks", TRAIN, f"{TRAIN_FILE}.tsv")
    resources:
        mem_mb=memory_of_training,
        **GPU,
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
