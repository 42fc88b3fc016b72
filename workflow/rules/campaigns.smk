# Campaigns: one table of what is asked, over any settings with any values; `snakemake campaign_{name}`.


wildcard_constraints:
    campaign="|".join(CAMPAIGNS) or "(?!)",
    batch="[a-z0-9_]+",


rule campaign_batch:
    """Some points of a campaign, one after another: each is kept by itself, and none is computed twice."""
    input:
        lambda wildcards: campaign_grouping.inputs(campaign_batch(wildcards)),
    output:
        "results/campaigns/{campaign}/{batch}.json",
    params:
        given=campaign_batch_given,
        batch=campaign_batch_points,
        read=lambda wildcards: campaign_of(wildcards.campaign).read,
        code=campaign_batch_code,
        library=library("campaign_batch.py", *STAGES),
    log:
        "results/logs/campaign_batch/{campaign}_{batch}.log",
    benchmark:
        "results/benchmarks/campaign_batch/{campaign}_{batch}.tsv"
    resources:
        mem_mb=4000,
    script:
        "../scripts/campaign_batch.py"


rule campaign_table:
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
        "results/logs/campaign_table/{campaign}.log",
    benchmark:
        "results/benchmarks/campaign_table/{campaign}.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/campaign_table.py"


for campaign in CAMPAIGNS:
    campaign_target = f"campaign_{campaign}"

    rule:
        """A campaign of config/campaigns, on demand: its table, and a page with its figures."""
        name:
            campaign_target
        input:
            table=f"results/campaigns/{campaign}.csv",
            parquet=f"results/campaigns/{campaign}.parquet",
        output:
            f"results/campaigns/{campaign}.html",
        params:
            given=lambda wildcards, campaign=campaign: campaign_given(campaign),
            campaign=campaign,
            library=library("campaign_page.py"),
        log:
            f"results/logs/campaign_{campaign}/all.log",
        benchmark:
            f"results/benchmarks/campaign_{campaign}/all.tsv"
        resources:
            mem_mb=1000,
        script:
            "../scripts/campaign_page.py"
