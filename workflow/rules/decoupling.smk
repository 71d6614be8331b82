"""Whether a task is as stiff as its gains: policies that hold a pose, pushed while they train."""

# empty where the configuration asks for none
DECOUPLING = STUDY.sections.get("decoupling", {})
PAIRINGS = DECOUPLING.get("pairings", [])
DECOUPLING_SEEDS = list(range(1, 1 + DECOUPLING.get("seeds", 0)))


wildcard_constraints:
    pairing="|".join(entry["name"] for entry in PAIRINGS) or "none",


rule decouple:
    output:
        stiffness=result("decoupling", "{pairing}", "seed{seed}", "stiffness.parquet"),
        policy=result("decoupling", "{pairing}", "seed{seed}", "policy.safetensors"),
    params:
        version=VERSION,
        decoupling={k: v for k, v in DECOUPLING.items() if k not in ("pairings", "seeds")},
        pairing=pairing_entry,
        task=lambda wildcards: dict(STUDY.tasks[DECOUPLING["task"]]),
        settings=TRAINING_SETTINGS
        | {key: DECOUPLING.get(key) for key in ("updates", "evaluate_every")},
        horizon_s=HORIZON_S,
        seed=SEED,
    threads: 1
    log:
        result("logs", "decouple", "{pairing}_{seed}.log"),
    benchmark:
        result("benchmarks", "decouple", "{pairing}_{seed}.tsv")
    resources:
        mem_mb=2000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/decouple.py"


rule decoupling_results:
    input:
        expand(
            result("decoupling", "{pairing}", "seed{seed}", "stiffness.parquet"),
            pairing=[entry["name"] for entry in PAIRINGS],
            seed=DECOUPLING_SEEDS,
        ),
    output:
        trainings=result("decoupling", "trainings.parquet"),
        table=captioned_table("decoupling", category="Decoupling"),
        figure=decoupling_figure("decoupling"),
    params:
        version=VERSION,
        pairings=PAIRINGS,
        seeds=DECOUPLING_SEEDS,
    log:
        result("logs", "decoupling_results.log"),
    benchmark:
        result("benchmarks", "decoupling_results.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/decoupling_results.py"


DECOUPLING_FIGURES, DECOUPLING_TABLES, DECOUPLING_RESULTS = [], [], []
if DECOUPLING:
    DECOUPLING_FIGURES += rules.decoupling_results.output.figure
    DECOUPLING_TABLES += rules.decoupling_results.output.table
    DECOUPLING_RESULTS += [
        *rules.decoupling_results.output,
        *expand(
            rules.decouple.output,
            pairing=[entry["name"] for entry in PAIRINGS],
            seed=DECOUPLING_SEEDS,
        ),
    ]
