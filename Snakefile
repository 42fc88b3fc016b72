# mammosim as one reproducible study: `snakemake --cores 2` regenerates every table and figure.
from snakemake.utils import min_version

min_version("9.0")


configfile: f"{workflow.basedir}/config/default.yaml"


include: "workflow/rules/common.smk"
include: "workflow/rules/code.smk"
include: "workflow/rules/women.smk"
include: "workflow/rules/pages.smk"
include: "workflow/rules/paths.smk"
include: "workflow/rules/progress.smk"


wildcard_constraints:
    v="[a-z0-9_]+",
    p="prone|supine|supine_tilted|upright",
    side="left|right",


# In the order in which one names what another made.
RULES = """
    chain volunteers images mesh morph mechanics unloading compression xray checks identification
    validation study hard_cases softening scene_variants scenes campaign_points campaigns
    recovery programs peers accuracy drawn report plan check
""".split()

for name in RULES:

    include: f"workflow/rules/{name}.smk"


rule study:
    """Every table and figure, and the report: results/study/report.html."""
    default_target: True
    input:
        "results/study/report.html",
        "results/study/numbers.json",
        "results/study/provenance.json",
        "results/segmentation/tissues.ctbl",
        over("results/women/{v}/what.html"),
