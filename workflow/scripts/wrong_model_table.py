"""Errors and moduli of a woman whom the fit's model cannot describe, beside those of a reference."""

import _log
import pandas as pd

from mammosim.io.tables import read_table, write_numbers, write_table
from mammosim.study.identification.validation import costs, moduli_beside, wrong_model_numbers


def main(files: dict, references: dict[str, str]) -> None:
    validation, moduli = (
        pd.concat(map(read_table, files[name]), ignore_index=True) for name in ("validated", "found")
    )
    table, beside = costs(validation, references), moduli_beside(moduli, references)
    write_table(table, files["table"])
    write_table(beside, files["moduli"])
    write_numbers(wrong_model_numbers(table, beside), files["numbers"])


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    inputs = {"validated": snakemake.input.validated, "found": snakemake.input.moduli}
    main(inputs | dict(snakemake.output.items()), dict(snakemake.params.references))
