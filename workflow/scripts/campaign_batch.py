"""Some points of a campaign, one after another, each kept in a file of its own when it is done."""

from pathlib import Path

import _log
import _stage

from mammosim.chain.files import chain_of
from mammosim.core.progress import progress
from mammosim.io.tables import write_json
from mammosim.study.campaigns.batch import Batch, items
from mammosim.study.campaigns.failures import Failures
from mammosim.study.jobs.last_words import LOCKED_BY, Run

POINTS, PRODUCTS = Path("results/campaigns/points"), Path("results/campaigns/products")


def main(settings: dict, out: str) -> None:
    given = settings["batch"]
    points = items(given["points"], given["kept"])
    batch = Batch(
        chain_of(settings["given"], {}),
        settings["read"],
        POINTS,
        PRODUCTS,
        settings["code"],
        Failures(Run.began(LOCKED_BY)),
    )
    whose = {name: given[name] for name in ("volunteer", "side")}
    rows = [{**whose, **row} for row in progress(batch.rows(points), label="points", total=len(points))]
    write_json(rows, out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(_stage.settings(snakemake), snakemake.output[0])
