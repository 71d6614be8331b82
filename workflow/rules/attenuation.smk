"""What controllers leave of errors of commands: theory, replays under noise, success."""

from t2l.actions import ACTIONS

# one row a cell and training seed: where behaviour cloning ends
CLONED = result("{task}", NOMINAL, "cells.parquet")
ATTENUATION = STUDY.sections["attenuation"]
HELD_NOISE = result("attenuation", "held_noise.parquet")
# noise in rad is for commands in rad
IN_RAD = ACTIONS.find(STUDY.sections["actions"]["kind"]).controller == "joint_pd"
NOISY_TASKS = TASKS if IN_RAD else []
EVERY_NOISY_REPLAY = expand(
    result("{task}", "noise", "{cell}", "noisy_replays.parquet"), task=NOISY_TASKS, cell=CELLS
)
EVERY_NOISY_CELL = [
    HELD_NOISE,
    *EVERY_NOISY_REPLAY,
    *expand(
        result("{task}", "noise", "{cell}", "noisy_traces.parquet"), task=NOISY_TASKS, cell=CELLS
    ),
]
NOISE_FIGURES = [
    *expand(result("figures", "attenuation.{suffix}"), suffix=FORMATS),
    *(expand(result("figures", "effective_error.{suffix}"), suffix=FORMATS) if NOISY_TASKS else []),
    *expand(
        result("figures", "{task}_{name}.{suffix}"),
        task=NOISY_TASKS,
        name=["noise", "noise_traces"],
        suffix=FORMATS,
    ),
]
NOISE_TABLES = [
    result("tables", f"{name}.{suffix}")
    for name in ["attenuation", *(["effective_error", "noise"] if NOISY_TASKS else [])]
    for suffix in ("csv", "md", "tex")
]
OPPOSITES = [cell.name for cell in STUDY.grid.opposites]


rule held_noise:
    output:
        HELD_NOISE,
    params:
        version=VERSION,
        cells=CELLS,
        robot=STUDY.sections["robot"]["name"],
        decimation=VARIANTS[NOMINAL]["decimation"],
        seed=SEED,
        settings={
            key: ATTENUATION[key]
            for key in ("noise_rad", "inertias_kg_m2", "replicates", "time_constants")
        },
    log:
        result("logs", "held_noise.log"),
    benchmark:
        result("benchmarks", "held_noise.tsv")
    threads: 2
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/held_noise.py"


rule attenuation:
    input:
        HELD_NOISE,
    output:
        figure=study_figure("attenuation"),
        table=study_table("attenuation"),
    params:
        version=VERSION,
        grid=STUDY.sections["grid"],
    log:
        result("logs", "attenuation.log"),
    benchmark:
        result("benchmarks", "attenuation.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/attenuation.py"


rule effective_error:
    input:
        cells=expand(CLONED, task=NOISY_TASKS),
        published=PUBLISHED,
    output:
        figure=study_figure("effective_error"),
        table=study_table("effective_error"),
    params:
        version=VERSION,
        tasks=NOISY_TASKS,
        grid=STUDY.sections["grid"],
        rate_hz=STUDY.sections["retargeting"]["policy_rate_hz"],
    log:
        result("logs", "effective_error.log"),
    benchmark:
        result("benchmarks", "effective_error.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/effective_error.py"


rule noisy_replays:
    input:
        demonstrations=DEMONSTRATIONS,
        cells=CLONED,
    output:
        replays=result("{task}", "noise", "{cell}", "noisy_replays.parquet"),
        traces=result("{task}", "noise", "{cell}", "noisy_traces.parquet"),
    params:
        version=VERSION,
        task=task_parameters,
        actions=STUDY.sections["actions"],
        decimation=VARIANTS[NOMINAL]["decimation"],
        hold=STUDY.sections["retargeting"]["hold"],
        repetitions=ATTENUATION["replays"],
        seed=SEED,
    log:
        result("logs", "noisy_replays", "{task}_{cell}.log"),
    benchmark:
        result("benchmarks", "noisy_replays", "{task}_{cell}.tsv")
    resources:
        mem_mb=2000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/noisy_replays.py"


rule noise_figures:
    input:
        cells=CLONED,
        replays=expand(
            result("{task}", "noise", "{cell}", "noisy_replays.parquet"), cell=CELLS, allow_missing=True
        ),
        traces=expand(
            result("{task}", "noise", "{cell}", "noisy_traces.parquet"),
            cell=OPPOSITES,
            allow_missing=True,
        ),
    output:
        success=figure("noise", "noise"),
        traces=figure("noise_traces", "noise_traces"),
    params:
        version=VERSION,
        grid=STUDY.sections["grid"],
        opposites=OPPOSITES,
    log:
        result("logs", "noise_figures", "{task}.log"),
    benchmark:
        result("benchmarks", "noise_figures", "{task}.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/noise_figures.py"


rule noise_table:
    input:
        cells=expand(CLONED, task=NOISY_TASKS),
        replays=expand(
            result("{task}", "noise", "{cell}", "noisy_replays.parquet"), task=NOISY_TASKS, cell=CELLS
        ),
    output:
        study_table("noise"),
    params:
        version=VERSION,
        tasks=NOISY_TASKS,
        grid=STUDY.sections["grid"],
    log:
        result("logs", "noise_table.log"),
    benchmark:
        result("benchmarks", "noise_table.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/noise_table.py"
