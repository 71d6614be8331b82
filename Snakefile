from pathlib import Path

from snakemake.exceptions import WorkflowError
from snakemake.utils import min_version

from t2l.configuration import read_study
from t2l.errors import T2LError

min_version("9.27")


configfile: "config/config.yaml"


try:
    STUDY = read_study(config, Path(workflow.basedir) / "config")
except T2LError as error:
    raise WorkflowError(str(error)) from None


report: "workflow/report/workflow.rst"


include: "workflow/rules/common.smk"
include: "workflow/rules/demonstrations.smk"
include: "workflow/rules/behaviour_cloning.smk"
include: "workflow/rules/statistics.smk"
include: "workflow/rules/figures.smk"


localrules:
    all,
    figures,
    tables,


rule all:
    default_target: True
    input:
        FIGURES,
        TABLES,


rule figures:
    input:
        FIGURES,


rule tables:
    input:
        TABLES,
