"""Recordings, and the training simulators that are identified from them."""

ROBOT = STUDY.sections["robot"]
# in real time, of which the profile says there is one
ROBOTS_USED = 1 if STUDY.robot.real_time else 0
IDENTIFICATION = STUDY.sections["identification"]
TRANSFER_CELLS = [cell.name for cell in STUDY.transfer_cells]
SHOWN_CELLS = [
    cell.name for cell in STUDY.recording_grid.corners if cell in STUDY.transfer_cells
]


rule record_motion:
    input:
        lambda wildcards: recorded_files(ROBOT, wildcards.cell),
    output:
        table=of_transfer("recording.parquet"),
        metadata=of_transfer("recording.yaml"),
    params:
        version=VERSION,
        robot=ROBOT,
        motion=STUDY.sections["recordings"],
    log:
        result("logs", "record_motion", "{cell}.log"),
    benchmark:
        result("benchmarks", "record_motion", "{cell}.tsv")
    resources:
        mem_mb=1000,
        robot=ROBOTS_USED,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/record_motion.py"


rule identify_actuators:
    input:
        tables=expand(of_transfer("recording.parquet"), cell=TRANSFER_CELLS),
        metadata=expand(of_transfer("recording.yaml"), cell=TRANSFER_CELLS),
    output:
        actuators=result("sim_to_real", "actuators.yaml"),
        losses=result("sim_to_real", "actuator_losses.parquet"),
    params:
        version=VERSION,
        rounds=IDENTIFICATION["iterations"],
    log:
        result("logs", "identify_actuators.log"),
    benchmark:
        result("benchmarks", "identify_actuators.tsv")
    resources:
        mem_mb=2000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/identify_actuators.py"


rule identify:
    input:
        unpack(shared_actuators),
        table=of_transfer("recording.parquet"),
        metadata=of_transfer("recording.yaml"),
    output:
        parameters=of_transfer("parameters.yaml"),
        losses=of_transfer("identification_losses.parquet"),
        trace=of_transfer("identification_trace.parquet"),
    params:
        version=VERSION,
        seed=SEED,
        settings=IDENTIFICATION,
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
    params:
        version=VERSION,
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
        version=VERSION,
        grid=STUDY.sections["recording_grid"],
        gains=IDENTIFICATION["gains"],
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


# What is true is known where the robot is a simulation, and read by this rule alone.
rule identified_over_true:
    input:
        expand(of_transfer("parameters.yaml"), cell=TRANSFER_CELLS),
    output:
        figure=transfer_figure("identified_over_true", "identified_over_true"),
        table=captioned_table("identified_over_true"),
    params:
        version=VERSION,
        robot=ROBOT,
        cells=TRANSFER_CELLS,
        gains=IDENTIFICATION["gains"],
    log:
        result("logs", "identified_over_true.log"),
    benchmark:
        result("benchmarks", "identified_over_true.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/identified_over_true.py"


IDENTIFICATION_FIGURES = [
    *rules.identification_figure.output.error,
    *rules.identification_figure.output.overlays,
]
IDENTIFICATION_TABLES = []
if STUDY.robot.truth_known:
    IDENTIFICATION_FIGURES += [*rules.identified_over_true.output.figure]
    IDENTIFICATION_TABLES += [*rules.identified_over_true.output.table]
