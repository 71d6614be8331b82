"""How easily action scales are found at the corners of the grid, and whether they work again."""

# empty where the configuration asks for none
LANDSCAPE = STUDY.sections.get("landscape", {})
LANDSCAPE_CELLS = [
    (condition, cell)
    for condition in (SEARCHED if LANDSCAPE else [])
    for cell in CELLS_OF[condition]
    if cell in SHOWN_CELLS
]


wildcard_constraints:
    configuration=r"\d+",


rule train_again:
    input:
        trials=of_condition("trials.parquet"),
        parameters=of_transfer("parameters.yaml"),
    output:
        result("sim_to_real", "{condition}", "{cell}", "again", "{configuration}_seed{seed}.parquet"),
    params:
        version=VERSION,
        condition=condition_entry,
        settings=TRAINING_SETTINGS,
        horizon_s=HORIZON_S,
        rate_hz=STUDY.sections["identification"]["rate_hz"],
        tuning={k: v for k, v in TUNING.items() if k != "workers"},
        landscape={k: LANDSCAPE.get(k) for k in ("passed", "configurations")},
    threads: 1
    log:
        result("logs", "train_again", "{condition}_{cell}_{configuration}_{seed}.log"),
    benchmark:
        result("benchmarks", "train_again", "{condition}_{cell}_{configuration}_{seed}.tsv")
    resources:
        mem_mb=2000,
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
        again=[
            path
            for condition, cell in LANDSCAPE_CELLS
            for path in expand(
                rules.train_again.output,
                condition=condition,
                cell=cell,
                configuration=range(1, 1 + LANDSCAPE.get("configurations", 0)),
                seed=range(1, 1 + LANDSCAPE.get("seeds", 0)),
            )
        ],
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
