"""One value of one numerical parameter: what is answered with it, and its processor time and memory."""

import _log

from mammosim.chain.files import chain_of
from mammosim.core.settings import read
from mammosim.io.tables import write_table
from mammosim.study.accuracy.parameters import NumericalParameter, Repeats
from mammosim.study.accuracy.trial import Trial, start_files


def main(files: dict, given: dict, parameter: NumericalParameter, repeats: Repeats, out: str) -> None:
    today = chain_of(given, files).kept(start_files(files["start"]))
    write_table(Trial(today, parameter, repeats).rows(), out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(
        dict(snakemake.input.items()),
        snakemake.params.given,
        read(NumericalParameter, snakemake.params.parameter, "the parameter"),
        read(Repeats, snakemake.params.repeats, "repeats"),
        snakemake.output[0],
    )
