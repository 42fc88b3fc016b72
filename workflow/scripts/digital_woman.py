"""The configured parameters of a virtual patient, checked, as the rules that make her read them."""

import _log

from mammosim.digital.patient import VirtualPatient
from mammosim.io.tables import write_json


def main(name: str, values: dict, out: str) -> None:
    write_json(VirtualPatient.read(values, at=f"digital.women.{name}").values(), out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(snakemake.wildcards.w, snakemake.params.woman, snakemake.output[0])
