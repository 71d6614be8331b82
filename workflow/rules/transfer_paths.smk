"""Which policies there are in the chain of transfer, and where their artefacts live."""

TUNING = STUDY.sections["tuning"]
ONE_WORKER = {key: value for key, value in TUNING.items() if key != "workers"}
HORIZON_S = STUDY.sections["reinforcement_learning"]["horizon_s"]
TRAINING_SETTINGS = {
    key: value
    for key, value in STUDY.sections["reinforcement_learning"].items()
    if key != "horizon_s"
}
CONDITION_NAMES = [entry["name"] for entry in CONDITIONS]
POLICY_SEEDS = range(1, 1 + STUDY.sections["sim_to_real"]["seeds"])
DECISION = STUDY.sections.get("transfer_decision")
ABLATION = STUDY.sections.get("robot_ablation")
# of each condition, by its name
CELLS_OF = {
    condition.name: [cell.name for cell in condition.cells(STUDY.transfer_cells)]
    for condition in STUDY.conditions
}


def of_conditions(path: str, conditions: list[str], cells: list[str] = TRANSFER_CELLS) -> list[str]:
    """The paths of an artefact for the cells of conditions, and for the seeds if it has them."""
    return [
        each
        for condition in conditions
        for each in expand(
            path,
            condition=condition,
            cell=[cell for cell in CELLS_OF[condition] if cell in cells],
            seed=POLICY_SEEDS,
        )
    ]


def of_one_condition(path: str):
    """An input function: `of_conditions` of the wildcard."""
    return lambda wildcards: of_conditions(path, [wildcards.condition])


def workers(wildcards) -> list[str]:
    """What says that a cell's trials are done, where there are any."""
    if wildcards.condition not in SEARCHED:
        return []
    several = 1 if SIDE_BY_SIDE else TUNING["workers"]
    return expand(of_condition("worker_{worker}.txt"), **wildcards, worker=range(several))


SEARCHED = [condition.name for condition in STUDY.conditions if condition.searched]


# A job trains one policy, or all of a condition. The latter has a rule of its own, because which
# cells it has is no matter of wildcards.
def jobs_for(conditions) -> list[str]:
    """The conditions that have a rule each; or the wildcard, of the rule that all have."""
    return list(conditions) if SIDE_BY_SIDE else ["{condition}"]


def all_of(condition: str, **every) -> dict:
    """For `in_one_job`: what wildcards are in a job that trains all policies of a condition."""
    return {"condition": condition, **every} if SIDE_BY_SIDE else {}


def name_of_job(name: str, condition: str) -> str:
    """Of what trains for a condition."""
    return f"{name}_{condition}" if SIDE_BY_SIDE else name


def file_of_job(condition: str, one: str) -> str:
    """What its log and benchmark are called: `one` of a policy."""
    return condition if SIDE_BY_SIDE else f"{condition}_{one}"


def entry_for(condition: str):
    """For `params` of such a job, the condition with the content of its task's file."""
    return entry_of(condition) if SIDE_BY_SIDE else condition_entry


MEMORY_OF_JOB = 8000 if SIDE_BY_SIDE else 2000


def of_ablated(path: str, **effect: str) -> list[str]:
    """The paths of an artefact for the policies whose robot is ablated."""
    if not (ABLATION and STUDY.conditions):
        return []
    return expand(
        path,
        condition=ABLATION["condition"],
        cell=[Cell(**entry).name for entry in ABLATION["cells"]],
        seed=POLICY_SEEDS,
        **effect,
    )


ABLATED = {f"without_{effect}": effect for effect in (ABLATION or {}).get("effects", [])}
