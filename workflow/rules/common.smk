"""The checked configuration, where results live, and which wildcards there are."""

import os
from dataclasses import asdict
import sys
from pathlib import Path, PurePosixPath

from snakemake.exceptions import WorkflowError
from snakemake.io import report as in_report

from t2l.bc.collections import collection, task_of
from t2l.config import SIMULATION_RATE_HZ, read_study
from t2l.errors import T2LError
from t2l.gains import Cell, corner_regions
from t2l.gains.cell import NAME_PATTERN
from t2l.outputs import claim
from t2l.seeds import generator
from t2l.threads import one_thread
from t2l.hardware import recorded_files
from t2l.version import with_extensions

try:
    STUDY = read_study(config, Path(workflow.basedir) / "config")
except T2LError as error:
    raise WorkflowError(str(error)) from None
# captions of the report take keys from it
config.update(STUDY.sections)

# one process a core
one_thread()
# with it, as containers set it, every job compiles its libraries anew: twice the time
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
# torch's threads wait without holding the core that the simulator's next step needs
os.environ.setdefault("GOMP_SPINCOUNT", "20000")


def result(*parts: str) -> str:
    """The path of an artefact of this study."""
    return str(PurePosixPath("results", STUDY.sections["study"], *parts))


def of_cell(artefact: str) -> str:
    """The path of an artefact that every cell of a variant has."""
    return result("{task}", "{variant}", "{cell}", artefact)


def one_of(names) -> str:
    """A pattern of names, which nothing matches where there are none."""
    return "|".join(sorted(names)) or "(?!)"


def of_clone(artefact: str) -> str:
    """The path of an artefact that every training seed of a cell has."""
    return of_cell(f"seed{{seed}}/{artefact}")


def of_variant(section: str):
    """For `params`: a section of the configuration as the job's variant has it."""
    return lambda wildcards: VARIANTS[wildcards.variant][section]


def like(variant: str, *sections: str) -> str:
    """The first variant with the same sections, which makes what follows from them for all."""
    own = VARIANTS[variant]
    return next(
        name
        for name, other in VARIANTS.items()
        if all(other[section] == own[section] for section in sections)
    )


def by_cell(artefact: str, **every):
    """For `input`: an artefact of a cell, or of `every` cell, of the variant that makes it."""
    return lambda wildcards: expand(
        of_cell(artefact), **every, variant=like(wildcards.variant, *LABELS), allow_missing=True
    )


def in_one_job(path: str, **every) -> list[str]:
    """The paths of an artefact that one job of training reads or makes.

    Args:
        every: what wildcards are in such a job, where it trains several policies.
    """
    return expand(path, **every, allow_missing=True)


def by_clone(artefact: str):
    """For `input`: an artefact of a policy, of the variant that makes it."""
    return lambda wildcards: expand(
        of_clone(artefact), variant=like(wildcards.variant, *TRAINED), allow_missing=True
    )[0]


def pictures(wildcards) -> str | list:
    """For `input`: the pictures that a variant's policies are trained on, if they see by cameras."""
    if not VARIANTS[wildcards.variant]["observation"]["cameras"]:
        return []
    variant = like(wildcards.variant, *SEEN)
    return result(wildcards.task, variant, "pictures")


def memory(wildcards) -> int:
    """For `resources`: MB of a job that may hold a variant's pictures."""
    return 4000 if VARIANTS[wildcards.variant]["observation"]["cameras"] else 2000


def memory_of_training(wildcards) -> int:
    """For `resources`: MB of a job that trains one policy, or all of a variant."""
    return memory_side_by_side(wildcards) if SIDE_BY_SIDE else memory(wildcards)


def trained_on(variant: str) -> dict[str, int]:
    """How many demonstrations a policy of each cell is to be trained on."""
    used = VARIANTS[variant]["demonstrations"].get("used") or DEMONSTRATED
    return {cell: used.get(cell, DEMONSTRATED) if isinstance(used, dict) else used for cell in CELLS}


def but_for_demonstrations(variant: dict) -> dict:
    """A variant without what varies with the number of demonstrations: that, and the epochs."""
    training = {key: value for key, value in variant["training"].items() if key != "epochs"}
    return {**variant, "training": training, "demonstrations": None}


def memory_side_by_side(wildcards) -> int:
    """For `resources`: MB of a job that trains all policies of a variant.

    To what one policy is given come 25 a policy, for weights, gradients, the optimiser's moments
    and a batch, and 0.25 an episode, which lies there twice while those of all cells are put
    together. Both are measured on a processor with the handover, whose observations are the largest
    (docs/speed.md). Of policies that see by cameras a processor would take more for each; that is
    not measured, and a GPU has it on its own.
    """
    policies, episodes = len(CELLS) * len(SEEDS), sum(trained_on(wildcards.variant).values())
    return round(memory(wildcards) + 25 * policies + 0.25 * episodes)


def of_transfer(artefact: str) -> str:
    """The path of an artefact that every cell of the sim-to-real chain has."""
    return result("sim_to_real", "cells", "{cell}", artefact)


def of_condition(artefact: str) -> str:
    """The path of an artefact that every cell of every condition has."""
    return result("sim_to_real", "{condition}", "{cell}", artefact)


def of_policy(artefact: str) -> str:
    """The path of an artefact that every policy of every such cell has."""
    return of_condition(f"seed{{seed}}/{artefact}")


def shared_actuators(wildcards) -> dict:
    """What a cell's simulator takes from the fit to all cells, where there is one."""
    if IDENTIFICATION["gains"] == "free":
        return {}
    return dict(rules.identify_actuators.output.items())


def captioned(path: str, caption: str, category: str = "Behaviour cloning"):
    """An output that `snakemake --report` shows with a caption, its path relative to the rules."""
    # str: the flag must not stick to a path that other rules use as input
    return in_report(str(path), caption=caption, category=category)


def figure(name: str, caption: str) -> list:
    """The files of one figure; the report shows the PNG, which the PDF would only repeat."""
    pdf, png = (result("figures", f"{{task}}_{name}.{suffix}") for suffix in FORMATS)
    return [pdf, captioned(png, f"../report/{caption}.rst")]


def transfer_figure(name: str, caption: str) -> list:
    """The files of one figure of the sim-to-real chain."""
    pdf, png = (result("figures", f"{name}.{suffix}") for suffix in FORMATS)
    return [pdf, captioned(png, f"../report/{caption}.rst", "Sim-to-real")]


def diagnosis_figure(name: str) -> list:
    """The files of one figure of the diagnosis."""
    pdf, png = (result("diagnosis", "figures", f"{name}.{suffix}") for suffix in FORMATS)
    return [pdf, captioned(png, f"../report/diagnosis_{name}.rst", "Diagnosis")]


def decoupling_figure(name: str) -> list:
    """The files of one figure of decoupling."""
    pdf, png = (result("figures", f"{name}.{suffix}") for suffix in FORMATS)
    return [pdf, captioned(png, f"../report/{name}.rst", "Decoupling")]


def learning_figure(name: str, caption: str) -> list:
    """The files of one figure of learning in simulation alone."""
    pdf, png = (result("figures", f"{name}.{suffix}") for suffix in FORMATS)
    return [pdf, captioned(png, f"../report/{caption}.rst", "Learning in simulation")]


def of_learned_cell(artefact: str) -> str:
    """The path of an artefact that a cell of such a task has."""
    return result("learning", "{learned}", "{cell}", artefact)


def of_learned(artefact: str) -> str:
    """The path of an artefact that every such policy has."""
    return of_learned_cell(f"seed{{seed}}/{artefact}")


def of_gain_search(artefact: str) -> str:
    """The path of an artefact of a search of gains."""
    return result("learning", "{searched}", "gains", artefact)


def searched_scales(wildcards) -> dict[str, str]:
    """For `input`: the action scales of a cell, where they are searched."""
    searched = [Cell(**cell).name for cell in LEARNED[wildcards.learned]["searched"]]
    if wildcards.cell not in searched:
        return {}
    return {"chosen": of_learned_cell("chosen.yaml").format(**wildcards)}


def of_every_learned(path: str, task: str = "") -> list[str]:
    """The paths of an artefact for all such policies, or those of a task."""
    policies = [own for own in LEARNED_POLICIES if task in ("", own["learned"])]
    return [path.format(**policy) for policy in policies]


def captioned_table(name: str, file: str = "", category: str = "Sim-to-real") -> list:
    """The files of one table, by default of the sim-to-real chain; the report shows the CSV."""
    csv, markdown, latex = multiext(result("tables", file or name), ".csv", ".md", ".tex")
    return [captioned(csv, f"../report/{name}_table.rst", category), markdown, latex]


def study_figure(name: str) -> list:
    """The files of a figure of all tasks."""
    pdf, png = (result("figures", f"{name}.{suffix}") for suffix in FORMATS)
    return [pdf, captioned(png, f"../report/{name}.rst")]


def study_table(name: str) -> list:
    """The files of a table of all tasks; the report shows the CSV."""
    csv, markdown, latex = multiext(result("tables", name), ".csv", ".md", ".tex")
    return [captioned(csv, f"../report/{name}_table.rst"), markdown, latex]


def task_parameters(wildcards) -> dict:
    """The content of the task's file, so that a change of it reruns what depends on it."""
    return dict(STUDY.tasks[task_of(wildcards.task)])


def entry_of(condition: str) -> dict:
    """A condition with the content of its task's file."""
    return next(entry for entry in CONDITIONS if entry["name"] == condition)


def condition_entry(wildcards) -> dict:
    """For `params`: that of the wildcard."""
    return entry_of(wildcards.condition)


def pairing_entry(wildcards) -> dict:
    """An entry of `decoupling.pairings`."""
    return next(entry for entry in PAIRINGS if entry["name"] == wildcards.pairing)


def wanted_decoupling(wildcards) -> list[str]:
    """What the target `decoupling` makes, or the key that it needs."""
    if not DECOUPLING:
        sys.exit("config: decoupling: found nothing; allowed: this section, such as {seeds: 3}")
    return DECOUPLING_RESULTS


def wanted_learning(wildcards) -> list[str]:
    """What the target `learning` makes, or the key that it needs."""
    if not LEARNING:
        sys.exit("config: learning: found nothing; allowed: this section, with tasks to learn")
    return LEARNING_RESULTS


def wanted_landscape(wildcards) -> list[str]:
    """What the target `landscape` makes, or the key that it needs."""
    if not LANDSCAPE:
        sys.exit("config: landscape: found nothing; allowed: this section, such as {seeds: 5}")
    return [*LANDSCAPE_FIGURES, *LANDSCAPE_TABLES, *rules.learning_figures.output.landscape]


def wanted_diagnosis(wildcards) -> list[str]:
    """What the target `diagnosis` makes, or the key that it needs."""
    if not DIAGNOSIS:
        # of an exception, Snakemake would show where in this file it comes from
        sys.exit(
            "config: diagnosis: found nothing; allowed: this section, with recordings to explain"
        )
    return DIAGNOSIS_RESULTS


# a parameter of every job: what another version, or other extensions, computed is made anew
VERSION = with_extensions(STUDY.sections.get("extensions", []))
TASKS = STUDY.sections["tasks"]
# of each task in turn, the first of them the task's own name
COLLECTIONS = [
    collection(task, number)
    for task in TASKS
    for number in range(STUDY.sections["collections"])
]
CONDITIONS = [asdict(condition) for condition in STUDY.conditions]
VARIANTS = STUDY.variants
# what decides what a policy is trained on, and how
LABELS = ("actions", "operator", "retargeting")
TRAINED = (*LABELS, "demonstrations", "observation", "training")
# what decides what pictures of the demonstrations there are
SEEN = ("observation", "retargeting")
# what the nominal's figures and tables show, and the other variants are compared with
NOMINAL = next(iter(VARIANTS))
SEEDS = list(range(STUDY.sections["training_seeds"]))
# whether one job trains all policies of a variant, or of a condition
SIDE_BY_SIDE = STUDY.sections["training_jobs"] == "variant"
GPU = {"gpu": 1} if SIDE_BY_SIDE else {}
CELLS = [cell.name for cell in STUDY.grid.cells]
SEED = STUDY.sections["seed"]
DEMONSTRATED = STUDY.sections["demonstrations"]["count"]

FORMATS = ("pdf", "png")
DEMONSTRATIONS = result("{task}", "demonstrations")


def rehearse(jobs) -> None:
    """Try what jobs are to demonstrate, collect or render, before the first of them starts."""
    # every job reads this file, and few need SciPy
    from t2l.demos.rehearsal import rehearse

    seen: dict[str, list[dict]] = {}
    for job in jobs:
        if job.rule.name in ("demonstrate", "collect", "render"):
            own = seen.setdefault(task_of(job.wildcards.task), [])
            if job.rule.name == "render":
                own.append(VARIANTS[job.wildcards.variant]["observation"])
    wanted = {key: STUDY.sections["demonstrations"][key] for key in ("count", "max_attempts")}
    for name, observations in seen.items():
        rng = generator(SEED, "rehearsal", name)
        rehearse(name, STUDY.tasks[name], **wanted, rng=rng, observations=observations)


onstart:
    try:
        rehearse(workflow.dag.needrun_jobs())
        claim(result(), "snakemake")
    except T2LError as error:
        raise WorkflowError(str(error)) from None


wildcard_constraints:
    task="|".join(COLLECTIONS),
    cell=NAME_PATTERN,
    variant="|".join(VARIANTS),
    seed=r"\d+",
