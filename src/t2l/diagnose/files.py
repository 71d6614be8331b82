"""Names of the files that a comparison, a diagnosis and an explanation leave in their folder."""

COMPARISON = "comparison.json"
TRACES = "traces.parquet"
DIAGNOSIS = "diagnosis.json"
EXPLANATION = "explanation.json"
MODEL = "model.yaml"
PROPOSAL = "proposal.json"
# of an explanation: the folder that holds it
PROPOSED = "proposal"
REPORT = "report.html"
# a folder
FIGURES = "figures"
# of an explanation, folders too: each step, and the comparisons with the recordings
STEPS = "steps"
BEFORE, AFTER = "before", "after"
