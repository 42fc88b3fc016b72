"""One breast with its fitted moduli, and with softer and stiffer ones."""

import _log

from mammosim.chain.breast import read_breast
from mammosim.chain.graph import Chain
from mammosim.chain.mechanics import PRODUCTS as MECHANICS
from mammosim.chain.xray import PRODUCTS as XRAY
from mammosim.io.tables import read_table, write_table
from mammosim.study.identification.softening import fitted_tissues, rows

# ASSUME: friction, weight and fascia, left out here, hardly change what other moduli change.
EFFECTS = frozenset({"gland", "muscle", "skin", "polychromatic", "paddle"})


def main(files: dict, job: dict, settings: dict, out: str) -> None:
    nu = float(read_table(files["fit"]).poisson_ratio.iloc[0])
    given = settings["settings"]
    tissues = fitted_tissues(
        read_table(files["moduli"]), given["tissues"], side=job["side"], poisson_ratio=nu
    )
    breast = read_breast(
        files, settings["gravity"], side=job["side"], names=(settings["seed"], *job.values(), "softening")
    )
    today = Chain(breast, given | {"tissues": tissues}, EFFECTS, {**MECHANICS, **XRAY})
    variants = [(tissue, factor) for tissue in ("glandular", "all") for factor in settings["factors"]]
    table = rows(today, variants)
    write_table(table.assign(**job)[[*job, *table.columns]], out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(
        dict(snakemake.input.items()),
        {"volunteer": snakemake.wildcards.v, "side": snakemake.wildcards.side},
        dict(snakemake.params.items()),
        snakemake.output[0],
    )
