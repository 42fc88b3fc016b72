"""All points of a campaign in one table, as text and as Parquet."""

import _log

from mammosim.io.parquet import write_parquet
from mammosim.io.tables import read_json, write_table
from mammosim.study.campaigns.campaign import Campaign
from mammosim.study.campaigns.table import frame


def main(files: list[str], campaign: Campaign, out: dict) -> None:
    table = frame(campaign, [row for path in files for row in read_json(path)])
    write_table(table, out["table"])
    write_parquet(table, out["parquet"])


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    name = snakemake.wildcards.campaign
    campaign = Campaign.of(name, snakemake.params.given, file=f"config/campaigns/{name}.yaml")
    main(list(snakemake.input.batches), campaign, dict(snakemake.output.items()))
