"""The configured parameters of a digital volunteer, as the rules that make her read them."""

import _log

from mammosim.io.tables import write_json


def main(woman: dict, out: str) -> None:
    write_json(woman, out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(snakemake.params.woman, snakemake.output[0])
