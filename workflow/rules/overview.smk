"""The study's first two figures: what gains do to a robot, and to each way of learning."""

# of metal, it is not stepped: no guard looks after that
STEPPED = STUDY.robot.takes_commands and not STUDY.robot.real_time


rule step_responses:
    output:
        result("sim_to_real", "step_responses.parquet"),
    params:
        version=VERSION,
        robot=ROBOT,
        cells=SHOWN_CELLS,
    log:
        result("logs", "step_responses.log"),
    benchmark:
        result("benchmarks", "step_responses.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/step_responses.py"


rule responses_figure:
    input:
        steps=result("sim_to_real", "step_responses.parquet"),
        traces=expand(of_transfer("identification_trace.parquet"), cell=SHOWN_CELLS),
    output:
        transfer_figure("responses", "responses"),
    params:
        version=VERSION,
        cells=SHOWN_CELLS,
        grid=STUDY.sections["recording_grid"],
    log:
        result("logs", "responses_figure.log"),
    benchmark:
        result("benchmarks", "responses_figure.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/responses_figure.py"


rule regimes_figure:
    input:
        cloning=expand(result("{task}", NOMINAL, "cells.parquet"), task=TASKS),
        transfer=expand(
            result("sim_to_real", "{condition}", "cells.parquet"), condition=CONDITION_NAMES[:1]
        ),
    output:
        transfer_figure("regimes", "regimes"),
    params:
        version=VERSION,
        grid=STUDY.sections["grid"],
        recording_grid=STUDY.sections["recording_grid"],
    log:
        result("logs", "regimes_figure.log"),
    benchmark:
        result("benchmarks", "regimes_figure.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/regimes_figure.py"


OVERVIEW_FIGURES = []
if STEPPED:
    OVERVIEW_FIGURES += rules.responses_figure.output
if CONDITION_NAMES:
    OVERVIEW_FIGURES += rules.regimes_figure.output
