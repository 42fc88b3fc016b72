"""One part of what scenes ask: the products that one job makes, kept as files, and what they took."""

import _log

from mammosim.chain.files import STORED, files_of, scene_chain
from mammosim.io.tables import write_json


def main(files: dict, settings: dict, out: dict) -> None:
    chain = scene_chain(files, settings["effects"], settings)
    made = {name: chain[name] for name in settings["products"]}
    for name, value in made.items():
        STORED[name].write(chain, value, files_of(name, out["files"]))
    took = {each: s for name in made for each, s in chain.seconds(name).items() if s > 0}
    write_json(took, out["seconds"])


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(dict(snakemake.input.items()), dict(snakemake.params.items()), dict(snakemake.output.items()))
