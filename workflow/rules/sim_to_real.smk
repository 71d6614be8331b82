"""Recordings of the robot at the other end, and a training simulator identified from each."""

ROBOT = STUDY.sections["robot"]
TRANSFER_CELLS = [cell.name for cell in STUDY.transfer_cells]
SHOWN_CELLS = [
    cell.name for cell in STUDY.recording_grid.corners if cell in STUDY.transfer_cells
]


rule record_motion:
    input:
        lambda wildcards: recorded_path(ROBOT, wildcards.cell),
    output:
        table=of_transfer("recording.parquet"),
        metadata=of_transfer("recording.yaml"),
    params:
        robot=ROBOT,
        motion=STUDY.sections["recordings"],
    log:
        result("logs", "record_motion", "{cell}.log"),
    benchmark:
        result("benchmarks", "record_motion", "{cell}.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/record_motion.py"


rule identify:
    input:
        table=of_transfer("recording.parquet"),
        metadata=of_transfer("recording.yaml"),
    output:
        parameters=of_transfer("parameters.yaml"),
        losses=of_transfer("identification_losses.parquet"),
        trace=of_transfer("identification_trace.parquet"),
    params:
        seed=SEED,
        settings=STUDY.sections["identification"],
    log:
        result("logs", "identify", "{cell}.log"),
    benchmark:
        result("benchmarks", "identify", "{cell}.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/identify.py"


rule summarise_identification:
    input:
        expand(of_transfer("parameters.yaml"), cell=TRANSFER_CELLS),
    output:
        result("sim_to_real", "identification.parquet"),
    log:
        result("logs", "summarise_identification.log"),
    benchmark:
        result("benchmarks", "summarise_identification.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/summarise_identification.py"


rule identification_figure:
    input:
        cells=result("sim_to_real", "identification.parquet"),
        losses=expand(of_transfer("identification_losses.parquet"), cell=TRANSFER_CELLS),
        traces=expand(of_transfer("identification_trace.parquet"), cell=SHOWN_CELLS),
    output:
        error=transfer_figure("identification", "identification"),
        overlays=transfer_figure("identification_overlays", "identification_overlays"),
    params:
        grid=STUDY.sections["recording_grid"],
    log:
        result("logs", "identification_figure.log"),
    benchmark:
        result("benchmarks", "identification_figure.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/identification_figure.py"


TRANSFER_FIGURES = [
    *rules.identification_figure.output.error,
    *rules.identification_figure.output.overlays,
]
