"""One breast with its fitted moduli, and with softer and stiffer ones."""

import _log
import _stage

from mammosim.chain.files import chain_of
from mammosim.core.settings import read
from mammosim.io.tables import read_table, write_table
from mammosim.study.identification.moduli import Materials, Moduli
from mammosim.study.identification.softening import rows


def main(files: dict, job: dict, settings: dict, out: str) -> None:
    nu = float(read_table(files["fit"]).poisson_ratio.iloc[0])
    assumed = chain_of(settings["given"], files)
    moduli = Moduli.of_rows(read_table(files["moduli"]))
    fitted = moduli.materials(
        read(Materials, assumed.setting("tissues"), "tissues"), job["side"], poisson_ratio=nu
    )
    variants = [(tissue, factor) for tissue in ("glandular", "all") for factor in settings["factors"]]
    table = rows(assumed, fitted, variants)
    write_table(table.assign(**job)[[*job, *table.columns]], out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(
        dict(snakemake.input.items()),
        {"volunteer": snakemake.wildcards.v, "side": snakemake.wildcards.side},
        _stage.settings(snakemake),
        snakemake.output[0],
    )
