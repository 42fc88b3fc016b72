# Campaigns: one table of what is asked, over any settings with any values; `snakemake campaign_{name}`.
# No name of a rule here begins with `campaign_`, so that a campaign may have any name.


wildcard_constraints:
    campaign="|".join(map(re.escape, CAMPAIGNS)) or "(?!)",
    batch="[a-z0-9_]+",


rule campaigns_batch:
    """Some points of a campaign, one after another: each is kept by itself, and none is computed twice."""
    input:
        lambda wildcards: campaign_job(*wildcards)["inputs"],
    output:
        "results/campaigns/{campaign}/{batch}.json",
    params:
        given=lambda wildcards: campaign_job(*wildcards)["given"],
        batch=lambda wildcards: campaign_job(*wildcards)["batch"],
        read=lambda wildcards: campaign_job(*wildcards)["read"],
        code=lambda wildcards: campaign_job(*wildcards)["code"],
        library=library("campaign_batch.py", *STAGES),
    log:
        "results/logs/campaigns_batch/{campaign}_{batch}.log",
    benchmark:
        "results/benchmarks/campaigns_batch/{campaign}_{batch}.tsv"
    resources:
        mem_mb=4000,
    script:
        "../scripts/campaign_batch.py"


rule campaigns_table:
    """All points of a campaign in one table: what varies, each answer with its error, outcome, reason and seconds."""
    input:
        batches=lambda wildcards: campaign_batches(wildcards.campaign),
    output:
        table="results/campaigns/{campaign}.csv",
        parquet="results/campaigns/{campaign}.parquet",
    params:
        given=lambda wildcards: campaign_given(wildcards.campaign),
        library=library("campaign_table.py"),
    log:
        "results/logs/campaigns_table/{campaign}.log",
    benchmark:
        "results/benchmarks/campaigns_table/{campaign}.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/campaign_table.py"


rule campaigns_page:
    """The figures of a campaign, what explains each answer, and which points have none, on one page."""
    input:
        table="results/campaigns/{campaign}.csv",
        scripts=PAGE_SCRIPTS,
    output:
        "results/campaigns/{campaign}.html",
    params:
        given=lambda wildcards: campaign_given(wildcards.campaign),
        library=library("campaign_page.py"),
    log:
        "results/logs/campaigns_page/{campaign}.log",
    benchmark:
        "results/benchmarks/campaigns_page/{campaign}.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/campaign_page.py"


for campaign in CAMPAIGNS:
    campaign_target = f"campaign_{campaign}"

    rule:
        """A campaign of config/campaigns, on demand: table and page; fails where the program itself did in a point."""
        name:
            campaign_target
        input:
            table=f"results/campaigns/{campaign}.csv",
            parquet=f"results/campaigns/{campaign}.parquet",
            page=f"results/campaigns/{campaign}.html",
            batches=lambda wildcards, campaign=campaign: campaign_batches(campaign),
        output:
            f"results/campaigns/{campaign}/complete.txt",
        params:
            library=library("campaign_end.py"),
        log:
            f"results/logs/campaign_{campaign}/all.log",
        benchmark:
            f"results/benchmarks/campaign_{campaign}/all.tsv"
        localrule: True
        retries: 0  # the same command tries the points again
        resources:
            mem_mb=1000,
        script:
            "../scripts/campaign_end.py"
