"""Every strategy's compression beside its image and dose."""

import _stage

from mammosim.io.tables import HOLDING_DIGITS, read_rows, write_table
from mammosim.study.report.trade_off import trade_off


def main(compression: str, image: str, out: str) -> None:
    write_table(trade_off(read_rows(compression), read_rows(image)), out, digits=HOLDING_DIGITS)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(snakemake.input.compression, snakemake.input.image, snakemake.output[0])
