"""The statements of the study that can be tested, its numbers, ours, and a verdict for each."""

from t2l.study.evidence import found_in

SCOREBOARD = multiext(result("tables", "scoreboard"), ".csv", ".md", ".tex", ".html")
# results of other studies that are there when the jobs are planned
OTHER_STUDIES = STUDY.sections.get("scoreboard", {}).get("studies", [])


# what this study makes, then what others have; a table that is not made is `not run`
EVIDENCE = [
    *expand(result("{task}", "{variant}", "cells.parquet"), task=COLLECTIONS, variant=VARIANTS),
    *EVERY_NOISY_REPLAY,
    HELD_NOISE,
    *expand(
        result("{task}", "fidelity", "{cell}.parquet"),
        task=TASKS,
        cell=[cell.name for cell in STUDY.fidelity_cells],
    ),
    result("sim_to_real", "identification.parquet"),
    *expand(
        result("sim_to_real", "{condition}", "{table}.parquet"),
        condition=CONDITION_NAMES,
        table=["cells", "rollouts"],
    ),
    *of_conditions(of_condition("trials.parquet"), SEARCHED, SHOWN_CELLS),
    *of_conditions(of_policy("training.parquet"), CONDITION_NAMES, SHOWN_CELLS),
    *EVERY_AGAIN,
    *(
        expand(result("tables", "transfer_decision_{condition}.csv"), condition=DECISION["condition"])
        if DECISION and STUDY.conditions
        else []
    ),
    *([result("decoupling", "trainings.parquet")] if DECOUPLING else []),
    *([result("learning", "policies.parquet")] if LEARNED else []),
    *(str(path) for name in OTHER_STUDIES for path in found_in(Path("results") / name)),
]


rule scoreboard:
    input:
        EVIDENCE,
    output:
        csv=SCOREBOARD[0],
        markdown=SCOREBOARD[1],
        latex=SCOREBOARD[2],
        page=captioned(SCOREBOARD[3], "../report/scoreboard.rst", "Scoreboard"),
    params:
        version=VERSION,
        robot=STUDY.sections["robot"]["name"],
    log:
        result("logs", "scoreboard.log"),
    benchmark:
        result("benchmarks", "scoreboard.tsv")
    resources:
        mem_mb=1000,
    conda:
        "../envs/t2l.yaml"
    script:
        "../scripts/scoreboard.py"
