"""Every strategy's compression beside its image and dose."""

import _log

from mammosim.io.tables import read_table, write_table
from mammosim.study.trade_off import trade_off


def main(compression: str, image: str, out: str) -> None:
    write_table(trade_off(read_table(compression), read_table(image)), out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(snakemake.input.compression, snakemake.input.image, snakemake.output[0])
