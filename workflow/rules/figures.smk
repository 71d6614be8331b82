"""Figures, each as PDF and PNG."""

FIGURES = expand(
    result("figures", "{task}_{name}.{suffix}"),
    task=TASKS,
    name=["success", "replay", "fidelity", "tracking", "frames"],
    suffix=FORMATS,
)
CORNERS = [cell.name for cell in STUDY.grid.corners]


rule success_figure:
    input:
        cells=result("{task}", NOMINAL, "cells.parquet"),
    output:
        success=figure("success", "success"),
        replay=figure("replay", "replay"),
    params:
        version=VERSION,
        grid=STUDY.sections["grid"],
    log:
        result("logs", "success_figure", "{task}.log"),
    benchmark:
        result("benchmarks", "success_figure", "{task}.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/success_figure.py"


rule fidelity_figure:
    input:
        expand(
            result("{task}", "fidelity", "{cell}.parquet"),
            cell=[cell.name for cell in STUDY.fidelity_cells],
            allow_missing=True,
        ),
    output:
        figure("fidelity", "fidelity"),
    params:
        version=VERSION,
        simulation_rate_hz=SIMULATION_RATE_HZ,
    log:
        result("logs", "fidelity_figure", "{task}.log"),
    benchmark:
        result("benchmarks", "fidelity_figure", "{task}.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/fidelity_figure.py"


rule tracking_figure:
    input:
        expand(
            of_cell("episodes.parquet"), variant=NOMINAL, cell=CORNERS, allow_missing=True
        ),
    output:
        figure("tracking", "tracking"),
    params:
        version=VERSION,
        task=task_parameters,
        actions=STUDY.sections["actions"],
        cells=CORNERS,
        rate_hz=STUDY.sections["retargeting"]["policy_rate_hz"],
    log:
        result("logs", "tracking_figure", "{task}.log"),
    benchmark:
        result("benchmarks", "tracking_figure", "{task}.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/tracking_figure.py"


rule frames_figure:
    input:
        demonstrations=DEMONSTRATIONS,
        traces=expand(
            of_clone("traces.parquet"),
            variant=NOMINAL,
            seed=SEEDS,
            cell=CELLS,
            allow_missing=True,
        ),
    output:
        figure("frames", "frames"),
    params:
        version=VERSION,
        task=task_parameters,
        # of each of the traces
        cells=[cell for _ in SEEDS for cell in CELLS],
        preferred=STUDY.grid.centre.name,
    log:
        result("logs", "frames_figure", "{task}.log"),
    benchmark:
        result("benchmarks", "frames_figure", "{task}.tsv")
    resources:
        mem_mb=2000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/frames_figure.py"
