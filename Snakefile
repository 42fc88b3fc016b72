# mammosim as one reproducible study: `snakemake --cores 2` regenerates every table and figure.
from snakemake.utils import min_version

min_version("9.0")


configfile: f"{workflow.basedir}/config/default.yaml"


include: "workflow/rules/common.smk"
include: "workflow/rules/progress.smk"


wildcard_constraints:
    v="[a-z0-9_]+",
    p="prone|supine|supine_tilted|upright",
    side="left|right",


include: "workflow/rules/volunteers.smk"
include: "workflow/rules/images.smk"
include: "workflow/rules/mesh.smk"
include: "workflow/rules/morph.smk"
include: "workflow/rules/mechanics.smk"
include: "workflow/rules/unloading.smk"
include: "workflow/rules/compression.smk"
include: "workflow/rules/xray.smk"
include: "workflow/rules/checks.smk"
include: "workflow/rules/identification.smk"
include: "workflow/rules/validation.smk"
include: "workflow/rules/study.smk"
include: "workflow/rules/figures.smk"
include: "workflow/rules/hard_cases.smk"
include: "workflow/rules/recovery.smk"
include: "workflow/rules/programs.smk"
include: "workflow/rules/peers.smk"
include: "workflow/rules/report.smk"


rule study:
    """Every table and figure, and the report: results/study/report.html."""
    default_target: True
    input:
        "results/study/report.html",
        "results/study/numbers.json",
        "results/study/provenance.json",
