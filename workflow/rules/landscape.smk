"""How easily action scales are found at the corners of the grid, and whether they work again."""

# empty where the configuration asks for none
LANDSCAPE = STUDY.sections.get("landscape", {})
LANDSCAPE_CELLS = [
    (condition, cell)
    for condition in (SEARCHED if LANDSCAPE else [])
    for cell in CELLS_OF[condition]
    if cell in SHOWN_CELLS
]


SHOWN_OF = {
    name: [cell for other, cell in LANDSCAPE_CELLS if other == name] for name, _ in LANDSCAPE_CELLS
}
AGAIN = of_condition("again/{configuration}_seed{seed}.parquet")
EVERY_AGAIN = [
    path
    for condition, cell in LANDSCAPE_CELLS
    for path in expand(
        AGAIN,
        condition=condition,
        cell=cell,
        configuration=range(1, 1 + LANDSCAPE["configurations"]),
        seed=range(1, 1 + LANDSCAPE["seeds"]),
    )
]


wildcard_constraints:
    configuration=r"\d+",


for CONDITION in jobs_for(SHOWN_OF):
    ALL = all_of(
        CONDITION,
        cell=SHOWN_OF.get(CONDITION),
        configuration=range(1, 1 + LANDSCAPE.get("configurations", 0)),
        seed=range(1, 1 + LANDSCAPE.get("seeds", 0)),
    )
    FILE = file_of_job(CONDITION, "{cell}_{configuration}_{seed}")

    rule:
        name:
            name_of_job("train_again", CONDITION)
        input:
            trials=in_one_job(of_condition("trials.parquet"), **ALL),
            parameters=in_one_job(of_transfer("parameters.yaml"), **ALL),
        output:
            in_one_job(AGAIN, **ALL),
        params:
            version=VERSION,
            condition=entry_for(CONDITION),
            settings=TRAINING_SETTINGS,
            horizon_s=HORIZON_S,
            rate_hz=STUDY.sections["identification"]["rate_hz"],
            tuning=ONE_WORKER,
            landscape={k: LANDSCAPE.get(k) for k in ("passed", "configurations")},
        threads: 1
        log:
            result("logs", "train_again", f"{FILE}.log"),
        benchmark:
            result("benchmarks", "train_again", f"{FILE}.tsv")
        resources:
            mem_mb=MEMORY_OF_JOB,
            **GPU,
        conda:
            "../envs/t2l.yaml"
        script:
            "../scripts/train_again.py"


rule landscape_results:
    input:
        trials=[
            path
            for condition, cell in LANDSCAPE_CELLS
            for path in expand(of_condition("trials.parquet"), condition=condition, cell=cell)
        ],
        again=EVERY_AGAIN,
    output:
        table=captioned_table("landscape"),
        figure=transfer_figure("sample_efficiency", "sample_efficiency"),
    params:
        version=VERSION,
        searched=LANDSCAPE_CELLS,
        landscape=LANDSCAPE,
        grid=STUDY.sections["recording_grid"],
    log:
        result("logs", "landscape_results.log"),
    benchmark:
        result("benchmarks", "landscape_results.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/landscape_results.py"


LANDSCAPE_FIGURES, LANDSCAPE_TABLES = [], []
if LANDSCAPE:
    LANDSCAPE_FIGURES += rules.landscape_results.output.figure
    LANDSCAPE_TABLES += rules.landscape_results.output.table
