"""Policies tuned in identified simulators, and their transfer to the robot."""

# as EVERY_CELL
EVERY_TRANSFER_CELL = (
    expand(
        of_transfer("{artefact}"),
        cell=TRANSFER_CELLS,
        artefact=["recording.parquet", "parameters.yaml", "identification_trace.parquet"],
    )
    + of_conditions(of_condition("trials.parquet"), CONDITION_NAMES)
    + [
        path
        for artefact in ("policy.safetensors", "rollouts.parquet", "traces.parquet")
        for path in of_conditions(of_policy(artefact), CONDITION_NAMES)
    ]
)


wildcard_constraints:
    condition="|".join(CONDITION_NAMES) or "none",
    worker=r"\d+",
    seed=r"\d+",


# A worker runs trials until the study has enough; several of them share it. The trials are in
# Optuna's storage, which outlives a job that was cut short.
# One job of a condition does the same as several workers, for all cells together.
for CONDITION in jobs_for(SEARCHED):
    ALL = all_of(CONDITION, cell=CELLS_OF.get(CONDITION), worker=0)
    FILE = file_of_job(CONDITION, "{cell}_{worker}")

    rule:
        name:
            name_of_job("tune", CONDITION)
        input:
            parameters=in_one_job(of_transfer("parameters.yaml"), **ALL),
        output:
            in_one_job(of_condition("worker_{worker}.txt"), **ALL),
        params:
            version=VERSION,
            condition=entry_for(CONDITION),
            settings=TRAINING_SETTINGS,
            horizon_s=HORIZON_S,
            rate_hz=STUDY.sections["identification"]["rate_hz"],
            tuning=TUNING if SIDE_BY_SIDE else ONE_WORKER,
            seed=SEED,
        threads: 1
        log:
            result("logs", "tune", f"{FILE}.log"),
        benchmark:
            result("benchmarks", "tune", f"{FILE}.tsv")
        resources:
            mem_mb=MEMORY_OF_JOB,
            **GPU,
        conda:
            "../envs/t2l.yaml"
        script:
            "../scripts/tune.py"


rule choose_scales:
    input:
        workers=workers,
    output:
        chosen=of_condition("chosen.yaml"),
        trials=of_condition("trials.parquet"),
    params:
        version=VERSION,
        condition=condition_entry,
        storage=TUNING["storage"],
        trials=TUNING["trials"],
        folder=subpath(output.chosen, parent=True),
    log:
        result("logs", "choose_scales", "{condition}_{cell}.log"),
    benchmark:
        result("benchmarks", "choose_scales", "{condition}_{cell}.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/choose_scales.py"


for CONDITION in jobs_for(CONDITION_NAMES):
    ALL = all_of(CONDITION, cell=CELLS_OF.get(CONDITION), seed=POLICY_SEEDS)
    FILE = file_of_job(CONDITION, "{cell}_{seed}")

    rule:
        name:
            name_of_job("train_policy", CONDITION)
        input:
            chosen=in_one_job(of_condition("chosen.yaml"), **ALL),
            parameters=in_one_job(of_transfer("parameters.yaml"), **ALL),
        output:
            policies=in_one_job(of_policy("policy.safetensors"), **ALL),
            outcomes=in_one_job(of_policy("outcome.yaml"), **ALL),
            training=in_one_job(of_policy("training.parquet"), **ALL),
        params:
            version=VERSION,
            condition=entry_for(CONDITION),
            settings=TRAINING_SETTINGS,
            horizon_s=HORIZON_S,
            rate_hz=STUDY.sections["identification"]["rate_hz"],
        threads: 1
        log:
            result("logs", "train_policy", f"{FILE}.log"),
        benchmark:
            result("benchmarks", "train_policy", f"{FILE}.tsv")
        resources:
            mem_mb=MEMORY_OF_JOB,
            **GPU,
        conda:
            "../envs/t2l.yaml"
        script:
            "../scripts/train_policies.py"


rule deploy:
    input:
        policy=of_policy("policy.safetensors"),
        parameters=of_transfer("parameters.yaml"),
    output:
        rollouts=of_policy("rollouts.parquet"),
        traces=of_policy("traces.parquet"),
        observations=of_policy("observations.parquet"),
    params:
        version=VERSION,
        condition=condition_entry,
        robot=ROBOT,
        deployment=STUDY.sections["deployment"],
        horizon_s=HORIZON_S,
        rate_hz=STUDY.sections["identification"]["rate_hz"],
        seed=SEED,
    log:
        result("logs", "deploy", "{condition}_{cell}_{seed}.log"),
    benchmark:
        result("benchmarks", "deploy", "{condition}_{cell}_{seed}.tsv")
    resources:
        mem_mb=1000,
        robot=ROBOTS_USED,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/deploy.py"


rule summarise_transfer:
    input:
        rollouts=of_one_condition(of_policy("rollouts.parquet")),
        outcomes=of_one_condition(of_policy("outcome.yaml")),
        chosen=of_one_condition(of_condition("chosen.yaml")),
    output:
        rollouts=result("sim_to_real", "{condition}", "rollouts.parquet"),
        cells=result("sim_to_real", "{condition}", "cells.parquet"),
    params:
        version=VERSION,
        seeds=len(POLICY_SEEDS),
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


rule transfer_decision:
    input:
        rollouts=result("sim_to_real", "{condition}", "rollouts.parquet"),
        policies=result("sim_to_real", "{condition}", "cells.parquet"),
    output:
        captioned_table("transfer_decision", "transfer_decision_{condition}"),
    params:
        version=VERSION,
        rule=DECISION,
    log:
        result("logs", "transfer_decision", "{condition}.log"),
    benchmark:
        result("benchmarks", "transfer_decision", "{condition}.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/transfer_decision.py"


rule deploy_without:
    input:
        policy=of_policy("policy.safetensors"),
        parameters=of_transfer("parameters.yaml"),
    output:
        of_policy("without/{effect}/rollouts.parquet"),
    params:
        version=VERSION,
        condition=condition_entry,
        robot=ROBOT,
        deployment=STUDY.sections["deployment"],
        horizon_s=HORIZON_S,
        rate_hz=STUDY.sections["identification"]["rate_hz"],
        seed=SEED,
    log:
        result("logs", "deploy_without", "{condition}_{cell}_{seed}_{effect}.log"),
    benchmark:
        result("benchmarks", "deploy_without", "{condition}_{cell}_{seed}_{effect}.tsv")
    resources:
        mem_mb=1000,
        robot=ROBOTS_USED,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/deploy_without.py"


rule ablation:
    input:
        whole=of_ablated(of_policy("rollouts.parquet")),
        **{
            key: of_ablated(of_policy("without/{effect}/rollouts.parquet"), effect=effect)
            for key, effect in ABLATED.items()
        },
    output:
        table=captioned_table("ablation"),
        figure=transfer_figure("ablation", "ablation"),
    params:
        version=VERSION,
        effects={effect: key for key, effect in ABLATED.items()},
        grid=STUDY.sections["recording_grid"],
    log:
        result("logs", "ablation.log"),
    benchmark:
        result("benchmarks", "ablation.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/ablation.py"


rule transfer_figures:
    input:
        cells=expand(result("sim_to_real", "{condition}", "cells.parquet"), condition=CONDITION_NAMES),
        traces=of_conditions(of_policy("traces.parquet"), CONDITION_NAMES[:1]),
        observations=of_conditions(of_policy("observations.parquet"), CONDITION_NAMES[:1]),
        rollouts=expand(
            result("sim_to_real", "{condition}", "rollouts.parquet"), condition=CONDITION_NAMES[:1]
        ),
    output:
        errors=transfer_figure("transfer", "transfer"),
        wrist=transfer_figure("wrist", "wrist"),
        observations=transfer_figure("observations", "observations"),
    params:
        version=VERSION,
        conditions=CONDITION_NAMES,
        grid=STUDY.sections["recording_grid"],
        policies=[
            (cell, seed) for name in CONDITION_NAMES[:1] for cell in CELLS_OF[name]
            for seed in POLICY_SEEDS
        ],
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


rule jitter_figure:
    input:
        result("tables", "jitter.csv"),
    output:
        transfer_figure("jitter", "jitter"),
    params:
        version=VERSION,
    log:
        result("logs", "jitter_figure.log"),
    benchmark:
        result("benchmarks", "jitter_figure.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/jitter_figure.py"


rule learning_figures:
    input:
        trials=of_conditions(of_condition("trials.parquet"), SEARCHED[:1], SHOWN_CELLS),
        **{
            f"training_{name}": of_conditions(of_policy("training.parquet"), [name], SHOWN_CELLS)
            for name in CONDITION_NAMES
        },
    output:
        landscape=transfer_figure("landscape", "landscape"),
        training=transfer_figure("training", "training"),
    params:
        version=VERSION,
        conditions=CONDITION_NAMES,
        cells=[cell for name in SEARCHED[:1] for cell in CELLS_OF[name] if cell in SHOWN_CELLS],
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
    # against a single rate it is one point
    if len({entry["policy_rate_hz"] for entry in CONDITIONS}) > 1:
        TRANSFER_FIGURES += [*rules.jitter_figure.output]
    if ABLATION:
        TRANSFER_FIGURES += [*rules.ablation.output.figure]
        TRANSFER_TABLES += [*rules.ablation.output.table]
    if DECISION:
        TRANSFER_TABLES += expand(rules.transfer_decision.output, condition=DECISION["condition"])
