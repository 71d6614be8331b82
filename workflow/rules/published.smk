"""Scoreboard, tables and figures of the documentation, made of kept results: nothing is trained."""

KEPT = sorted(str(path) for path in Path("docs/data").glob("*.csv"))
PAGES = [
    "README.md",
    *(f"docs/{name}.md" for name in ("scoreboard", "scoreboard_rules", "results_collections")),
]


rule published:
    input:
        data=KEPT,
        pages=PAGES,
        # the registered rule on transfer
        study="config/studies/transfer_decision.yaml",
    output:
        scoreboard=multiext("results/published/scoreboard", ".csv", ".md", ".tex", ".html"),
        findings="results/published/findings.md",
        tables=directory("results/published/tables"),
        figures=directory("results/published/figures"),
        pages=directory("results/published/pages"),
    params:
        version=VERSION,
    log:
        "results/published/logs/published.log",
    benchmark:
        "results/published/benchmarks/published.tsv"
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/published.py"
