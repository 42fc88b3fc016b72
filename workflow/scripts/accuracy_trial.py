"""One value of one knob: what is answered with it, and its processor time and memory."""

import _log

from mammosim.chain.files import chain_of
from mammosim.io.tables import write_table
from mammosim.study.accuracy.knobs import Knob
from mammosim.study.accuracy.start import start_files
from mammosim.study.accuracy.trial import Trial


def main(files: dict, given: dict, knob: Knob, repeats: dict, out: str) -> None:
    today = chain_of(given, files).kept(start_files(files["start"]))
    write_table(Trial(today, knob, repeats).rows(), out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(
        dict(snakemake.input.items()),
        snakemake.params.given,
        Knob.plain(snakemake.params.knob),
        snakemake.params.repeats,
        snakemake.output[0],
    )
