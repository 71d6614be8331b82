"""Compare a model with recordings, explain the difference, compare again."""

from importlib.metadata import version

from t2l.config.watched import watched

DIAGNOSIS = STUDY.sections.get("diagnosis", {})
DIAGNOSIS_FIGURES = expand(
    result("diagnosis", "figures", "{name}.{suffix}"),
    name=["error_falling", "overlays", "error_by_cell", "residual_by_condition", "spectrum"],
    suffix=FORMATS,
)


rule compare_before:
    input:
        lambda wildcards: watched(DIAGNOSIS),
    output:
        comparison=result("diagnosis", "before", "comparison.json"),
        traces=result("diagnosis", "before", "traces.parquet"),
    params:
        diagnosis=DIAGNOSIS,
        version=version("t2l"),
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
        diagnosis=DIAGNOSIS,
        version=version("t2l"),
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
        diagnosis=DIAGNOSIS,
        version=version("t2l"),
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
        figures=DIAGNOSIS_FIGURES,
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
