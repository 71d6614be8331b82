"""Tasks that are learned in simulation alone, under the gains of each cell as they are."""

# empty where the configuration asks for none
LEARNING = STUDY.sections.get("learning", {})
LEARNED = {entry["task"]: entry for entry in LEARNING.get("tasks", [])}
LEARNED_POLICIES = [
    {"learned": task, "cell": Cell(scale["kp"], scale["kd"]).name, "seed": seed}
    for task, entry in LEARNED.items()
    for scale in [*entry["action_scales"], *entry["searched"]]
    for seed in range(1, 1 + LEARNING["seeds"])
]
# tasks and cells whose action scales are searched
LEARNING_SEARCHED = [
    {"learned": task, "cell": Cell(**cell).name}
    for task, entry in LEARNED.items()
    for cell in entry["searched"]
]


# of tasks that are asked for at the four corners of a grid: their cells
AT_CORNERS = {
    task: sorted({own["cell"] for own in LEARNED_POLICIES if own["learned"] == task})
    for task in LEARNED
}
AT_CORNERS = {
    task: cells
    for task, cells in AT_CORNERS.items()
    if corner_regions(map(Cell.from_name, cells))
}


wildcard_constraints:
    learned="|".join(LEARNED) or "none",


rule search_learned:
    output:
        chosen=of_learned_cell("chosen.yaml"),
        trials=of_learned_cell("trials.parquet"),
    params:
        version=VERSION,
        entry=lambda wildcards: LEARNED[wildcards.learned],
        task=lambda wildcards: dict(STUDY.tasks[wildcards.learned]),
        settings=TRAINING_SETTINGS,
        tuning=TUNING,
        seed=SEED,
    threads: 1
    log:
        result("logs", "search_learned", "{learned}_{cell}.log"),
    benchmark:
        result("benchmarks", "search_learned", "{learned}_{cell}.tsv")
    resources:
        mem_mb=2000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/search_learned.py"


rule learning_trials:
    input:
        [of_learned_cell("trials.parquet").format(**own) for own in LEARNING_SEARCHED],
    output:
        captioned_table("learning_trials", category="Learning in simulation"),
    params:
        version=VERSION,
    log:
        result("logs", "learning_trials.log"),
    benchmark:
        result("benchmarks", "learning_trials.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/learning_trials.py"


rule learn:
    input:
        unpack(searched_scales),
    output:
        policy=of_learned("policy.safetensors"),
        training=of_learned("training.parquet"),
        outcome=of_learned("outcome.parquet"),
        episodes=of_learned("episodes.parquet"),
    params:
        version=VERSION,
        entry=lambda wildcards: LEARNED[wildcards.learned],
        task=lambda wildcards: dict(STUDY.tasks[wildcards.learned]),
        settings=TRAINING_SETTINGS,
        episodes=LEARNING.get("episodes"),
    threads: 1
    log:
        result("logs", "learn", "{learned}_{cell}_{seed}.log"),
    benchmark:
        result("benchmarks", "learn", "{learned}_{cell}_{seed}.tsv")
    resources:
        mem_mb=2000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/learn.py"


rule learning_results:
    input:
        outcomes=of_every_learned(of_learned("outcome.parquet")),
        trainings=of_every_learned(of_learned("training.parquet")),
    output:
        policies=result("learning", "policies.parquet"),
        table=captioned_table("learning", category="Learning in simulation"),
        figure=learning_figure("learning", "learning"),
    params:
        version=VERSION,
        tasks=[policy["learned"] for policy in LEARNED_POLICIES],
    log:
        result("logs", "learning_results.log"),
    benchmark:
        result("benchmarks", "learning_results.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/learning_results.py"


rule existence:
    input:
        rules.learning_results.output.policies,
    output:
        table=captioned_table("existence", category="Learning in simulation"),
        figure=learning_figure("existence", "existence"),
    params:
        version=VERSION,
        cells=AT_CORNERS,
    log:
        result("logs", "existence.log"),
    benchmark:
        result("benchmarks", "existence.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/existence.py"


rule learned_frames:
    input:
        lambda wildcards: of_every_learned(of_learned("episodes.parquet"), wildcards.learned)[0],
    output:
        learning_figure("{learned}_learned", "learned_frames"),
    params:
        version=VERSION,
        task=lambda wildcards: dict(STUDY.tasks[wildcards.learned]),
    log:
        result("logs", "learned_frames", "{learned}.log"),
    benchmark:
        result("benchmarks", "learned_frames", "{learned}.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/learned_frames.py"


LEARNING_FIGURES, LEARNING_TABLES, LEARNING_RESULTS = [], [], []
if LEARNED:
    LEARNING_FIGURES += rules.learning_results.output.figure
    LEARNING_FIGURES += expand(rules.learned_frames.output, learned=LEARNED)
    LEARNING_TABLES += rules.learning_results.output.table
    if LEARNING_SEARCHED:
        LEARNING_TABLES += rules.learning_trials.output
    if AT_CORNERS:
        LEARNING_FIGURES += rules.existence.output.figure
        LEARNING_TABLES += rules.existence.output.table
    LEARNING_RESULTS += [
        *rules.learning_results.output,
        *of_every_learned(of_learned("policy.safetensors")),
        *LEARNING_FIGURES,
        *LEARNING_TABLES,
    ]
