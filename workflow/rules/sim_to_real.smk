"""Policies tuned in identified simulators, and their transfer to the robot."""

TUNING = STUDY.sections["tuning"]
HORIZON_S = STUDY.sections["reinforcement_learning"]["horizon_s"]
TRAINING_SETTINGS = {
    key: value
    for key, value in STUDY.sections["reinforcement_learning"].items()
    if key != "horizon_s"
}
CONDITION_NAMES = [entry["name"] for entry in CONDITIONS]
TRAINING_SEEDS = range(1, 1 + STUDY.sections["sample_efficiency"]["seeds"])

# as EVERY_CELL
EVERY_TRANSFER_CELL = expand(
    of_transfer("{artefact}"),
    cell=TRANSFER_CELLS,
    artefact=["recording.parquet", "parameters.yaml", "identification_trace.parquet"],
) + expand(
    of_condition("{artefact}"),
    condition=CONDITION_NAMES,
    cell=TRANSFER_CELLS,
    artefact=["policy.safetensors", "trials.parquet", "rollouts.parquet", "traces.parquet"],
)


wildcard_constraints:
    condition="|".join(CONDITION_NAMES) or "none",
    worker=r"\d+",
    seed=r"\d+",


# A worker runs trials until the study has enough; several of them share it. The trials are in
# Optuna's storage, which outlives a job that was cut short.
rule tune:
    input:
        parameters=of_transfer("parameters.yaml"),
    output:
        result("sim_to_real", "{condition}", "{cell}", "worker_{worker}.txt"),
    params:
        version=VERSION,
        condition=condition_entry,
        settings=TRAINING_SETTINGS,
        horizon_s=HORIZON_S,
        rate_hz=STUDY.sections["identification"]["rate_hz"],
        tuning={k: v for k, v in TUNING.items() if k != "workers"},
        seed=SEED,
        folder=subpath(output[0], parent=True),
    threads: 1
    log:
        result("logs", "tune", "{condition}_{cell}_{worker}.log"),
    benchmark:
        result("benchmarks", "tune", "{condition}_{cell}_{worker}.tsv")
    resources:
        mem_mb=2000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/tune.py"


rule choose_policy:
    input:
        workers=expand(
            result("sim_to_real", "{condition}", "{cell}", "worker_{worker}.txt"),
            worker=range(TUNING["workers"]),
            allow_missing=True,
        ),
    output:
        policy=of_condition("policy.safetensors"),
        chosen=of_condition("chosen.yaml"),
        trials=of_condition("trials.parquet"),
        training=of_condition("training.parquet"),
    params:
        version=VERSION,
        storage=TUNING["storage"],
        trials=TUNING["trials"],
        folder=subpath(output.policy, parent=True),
    log:
        result("logs", "choose_policy", "{condition}_{cell}.log"),
    benchmark:
        result("benchmarks", "choose_policy", "{condition}_{cell}.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/choose_policy.py"


rule deploy:
    input:
        policy=of_condition("policy.safetensors"),
        parameters=of_transfer("parameters.yaml"),
    output:
        rollouts=of_condition("rollouts.parquet"),
        traces=of_condition("traces.parquet"),
        observations=of_condition("observations.parquet"),
    params:
        version=VERSION,
        condition=condition_entry,
        robot=ROBOT,
        deployment=STUDY.sections["deployment"],
        horizon_s=HORIZON_S,
        rate_hz=STUDY.sections["identification"]["rate_hz"],
        seed=SEED,
    log:
        result("logs", "deploy", "{condition}_{cell}.log"),
    benchmark:
        result("benchmarks", "deploy", "{condition}_{cell}.tsv")
    resources:
        mem_mb=1000,
        robot=ROBOTS_USED,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/deploy.py"


rule train_again:
    input:
        chosen=of_condition("chosen.yaml"),
        parameters=of_transfer("parameters.yaml"),
    output:
        result("sim_to_real", "{condition}", "{cell}", "seed_{seed}.parquet"),
    params:
        version=VERSION,
        condition=condition_entry,
        settings=TRAINING_SETTINGS
        | {"updates": STUDY.sections["sample_efficiency"]["updates"]},
        horizon_s=HORIZON_S,
        rate_hz=STUDY.sections["identification"]["rate_hz"],
        passed=STUDY.sections["sample_efficiency"]["passed"],
    threads: 1
    log:
        result("logs", "train_again", "{condition}_{cell}_{seed}.log"),
    benchmark:
        result("benchmarks", "train_again", "{condition}_{cell}_{seed}.tsv")
    resources:
        mem_mb=2000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/train_again.py"


rule summarise_transfer:
    input:
        rollouts=expand(of_condition("rollouts.parquet"), cell=TRANSFER_CELLS, allow_missing=True),
        chosen=expand(of_condition("chosen.yaml"), cell=TRANSFER_CELLS, allow_missing=True),
    output:
        rollouts=result("sim_to_real", "{condition}", "rollouts.parquet"),
        cells=result("sim_to_real", "{condition}", "cells.parquet"),
    params:
        version=VERSION,
    log:
        result("logs", "summarise_transfer", "{condition}.log"),
    benchmark:
        result("benchmarks", "summarise_transfer", "{condition}.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/summarise_transfer.py"


rule transfer_statistics:
    input:
        rollouts=expand(
            result("sim_to_real", "{condition}", "rollouts.parquet"), condition=CONDITION_NAMES
        ),
        cells=expand(result("sim_to_real", "{condition}", "cells.parquet"), condition=CONDITION_NAMES),
    output:
        transfer=captioned_table("transfer"),
        jitter=captioned_table("jitter"),
        existence=captioned_table("solution_existence"),
    params:
        version=VERSION,
        conditions=CONDITIONS,
        grid=STUDY.sections["recording_grid"],
    log:
        result("logs", "transfer_statistics.log"),
    benchmark:
        result("benchmarks", "transfer_statistics.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/transfer_tables.py"


rule transfer_figures:
    input:
        cells=expand(result("sim_to_real", "{condition}", "cells.parquet"), condition=CONDITION_NAMES),
        traces=expand(
            of_condition("traces.parquet"), condition=CONDITION_NAMES[:1], cell=TRANSFER_CELLS
        ),
        observations=expand(
            of_condition("observations.parquet"), condition=CONDITION_NAMES[:1], cell=TRANSFER_CELLS
        ),
        rollouts=expand(
            result("sim_to_real", "{condition}", "rollouts.parquet"), condition=CONDITION_NAMES[:1]
        ),
        jitter=result("tables", "jitter.csv"),
    output:
        errors=transfer_figure("transfer", "transfer"),
        jitter=transfer_figure("jitter", "jitter"),
        wrist=transfer_figure("wrist", "wrist"),
        observations=transfer_figure("observations", "observations"),
    params:
        version=VERSION,
        conditions=CONDITION_NAMES,
        cells=TRANSFER_CELLS,
        grid=STUDY.sections["recording_grid"],
    log:
        result("logs", "transfer_figures.log"),
    benchmark:
        result("benchmarks", "transfer_figures.tsv")
    resources:
        mem_mb=2000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/transfer_figures.py"


rule learning_figures:
    input:
        trials=expand(
            of_condition("trials.parquet"), condition=CONDITION_NAMES[:1], cell=SHOWN_CELLS
        ),
        seeds=expand(
            result("sim_to_real", "{condition}", "{cell}", "seed_{seed}.parquet"),
            condition=CONDITION_NAMES,
            cell=SHOWN_CELLS,
            seed=TRAINING_SEEDS,
        ),
    output:
        landscape=transfer_figure("landscape", "landscape"),
        training=transfer_figure("training", "training"),
    params:
        version=VERSION,
        conditions=CONDITION_NAMES,
        cells=SHOWN_CELLS,
        grid=STUDY.sections["recording_grid"],
    log:
        result("logs", "learning_figures.log"),
    benchmark:
        result("benchmarks", "learning_figures.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/learning_figures.py"


TRANSFER_FIGURES = [*IDENTIFICATION_FIGURES]
TRANSFER_TABLES = [*IDENTIFICATION_TABLES]
if CONDITION_NAMES:
    TRANSFER_FIGURES += [
        *rules.transfer_figures.output,
        *rules.learning_figures.output,
    ]
    TRANSFER_TABLES += [*rules.transfer_statistics.output]
