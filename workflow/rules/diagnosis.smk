"""Compare a model with recordings, explain the difference, compare again."""

from t2l.config.watched import watched

# empty where the configuration asks for none
DIAGNOSIS = STUDY.sections.get("diagnosis", {})


rule compare_before:
    input:
        lambda wildcards: watched(DIAGNOSIS),
    output:
        comparison=result("diagnosis", "before", "comparison.json"),
        traces=result("diagnosis", "before", "traces.parquet"),
    params:
        version=VERSION,
        diagnosis=DIAGNOSIS,
    log:
        result("logs", "compare_before.log"),
    benchmark:
        result("benchmarks", "compare_before.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/compare.py"


rule explain:
    input:
        lambda wildcards: watched(DIAGNOSIS),
    output:
        explanation=result("diagnosis", "explanation.json"),
        model=result("diagnosis", "model.yaml"),
    params:
        version=VERSION,
        diagnosis=DIAGNOSIS,
    log:
        result("logs", "explain.log"),
    benchmark:
        result("benchmarks", "explain.tsv")
    threads: 2
    resources:
        mem_mb=2000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/explain.py"


rule compare_after:
    input:
        lambda wildcards: watched(DIAGNOSIS),
        model=rules.explain.output.model,
    output:
        comparison=result("diagnosis", "after", "comparison.json"),
        traces=result("diagnosis", "after", "traces.parquet"),
    params:
        version=VERSION,
        diagnosis=DIAGNOSIS,
    log:
        result("logs", "compare_after.log"),
    benchmark:
        result("benchmarks", "compare_after.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/compare.py"


rule diagnosis_report:
    input:
        rules.compare_before.output,
        rules.compare_after.output,
        rules.explain.output,
    output:
        page=result("diagnosis", "report.html"),
        error_falling=diagnosis_figure("error_falling"),
        overlays=diagnosis_figure("overlays"),
        error_by_cell=diagnosis_figure("error_by_cell"),
        residual=diagnosis_figure("residual_by_condition"),
        spectrum=diagnosis_figure("spectrum"),
    params:
        version=VERSION,
    log:
        result("logs", "diagnosis_report.log"),
    benchmark:
        result("benchmarks", "diagnosis_report.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/diagnosis_report.py"


DIAGNOSIS_RESULTS = []
if DIAGNOSIS:
    DIAGNOSIS_RESULTS += [
        *rules.diagnosis_report.output,
        *rules.compare_before.output,
        *rules.compare_after.output,
        *rules.explain.output,
    ]
