"""One breast with its fitted moduli, and with softer and stiffer ones."""

import _log

from mammosim.chain.files import chain_of
from mammosim.io.tables import read_table, write_table
from mammosim.study.identification.softening import fitted_tissues, rows


def main(files: dict, job: dict, settings: dict, out: str) -> None:
    nu = float(read_table(files["fit"]).poisson_ratio.iloc[0])
    assumed = chain_of(settings["given"], files)
    moduli = read_table(files["moduli"])
    tissues = fitted_tissues(moduli, assumed.setting("tissues"), side=job["side"], poisson_ratio=nu)
    today = assumed.with_settings({"tissues": tissues, "load.tissues": tissues})
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
