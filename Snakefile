from snakemake.utils import min_version

min_version("9.27")


# a configuration that is given inherits nothing from this one
if not workflow.overwrite_configfiles:

    configfile: "config/config.yaml"


report: "workflow/report/workflow.rst"


include: "workflow/rules/common.smk"
include: "workflow/rules/demonstrations.smk"
include: "workflow/rules/behaviour_cloning.smk"
include: "workflow/rules/statistics.smk"
include: "workflow/rules/figures.smk"
include: "workflow/rules/attenuation.smk"
include: "workflow/rules/diagnosis.smk"
include: "workflow/rules/identification.smk"
include: "workflow/rules/transfer_paths.smk"
include: "workflow/rules/sim_to_real.smk"
include: "workflow/rules/landscape.smk"
include: "workflow/rules/overview.smk"
include: "workflow/rules/decoupling.smk"
include: "workflow/rules/learning.smk"
include: "workflow/rules/gain_search.smk"
include: "workflow/rules/scoreboard.smk"
include: "workflow/rules/published.smk"


localrules:
    all,
    datasets,
    decoupling,
    diagnosis,
    figures,
    landscape,
    learning,
    tables,
    transfer,


rule all:
    default_target: True
    input:
        FIGURES,
        REGIONS,
        SCALING,
        ANEW,
        NOISE_FIGURES,
        TRANSFER_FIGURES,
        OVERVIEW_FIGURES,
        TABLES,
        NOISE_TABLES,
        TRANSFER_TABLES,
        SCOREBOARD,
        EVERY_CELL,
        EVERY_NOISY_CELL,
        EVERY_TRANSFER_CELL,
        DIAGNOSIS_RESULTS,
        LANDSCAPE_FIGURES,
        LANDSCAPE_TABLES,
        DECOUPLING_RESULTS,
        LEARNING_RESULTS,


rule figures:
    input:
        FIGURES,
        REGIONS,
        SCALING,
        ANEW,
        NOISE_FIGURES,
        TRANSFER_FIGURES,
        OVERVIEW_FIGURES,
        LANDSCAPE_FIGURES,
        DECOUPLING_FIGURES,
        LEARNING_FIGURES,
        EVERY_CELL,
        EVERY_NOISY_CELL,
        EVERY_TRANSFER_CELL,


rule transfer:
    input:
        TRANSFER_FIGURES,
        TRANSFER_TABLES,
        EVERY_TRANSFER_CELL,


rule tables:
    input:
        TABLES,
        NOISE_TABLES,
        TRANSFER_TABLES,
        SCOREBOARD,
        LANDSCAPE_TABLES,
        DECOUPLING_TABLES,
        LEARNING_TABLES,
        EVERY_CELL,
        EVERY_NOISY_CELL,
        EVERY_TRANSFER_CELL,


rule datasets:
    input:
        DATASETS,


rule decoupling:
    input:
        wanted_decoupling,


rule learning:
    input:
        wanted_learning,


rule landscape:
    input:
        wanted_landscape,


rule diagnosis:
    input:
        wanted_diagnosis,
