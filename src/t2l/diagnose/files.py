"""Names of what `t2l compare`, `diagnose` and `explain` write into their folder."""

COMPARISON = "comparison.json"
TRACES = "traces.parquet"
DIAGNOSIS = "diagnosis.json"
EXPLANATION = "explanation.json"
MODEL = "model.yaml"
# folders
MODELS, STEPS, BEFORE, AFTER, FIGURES = "models", "steps", "before", "after", "figures"
REPORT = "report.html"
