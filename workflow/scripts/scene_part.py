"""One part of a scene's answer: the products that one job makes, kept as files, and what they took."""

import _log

from mammosim.io.tables import write_json
from mammosim.study.scene_files import STORED, files_of, scene_chain


def main(files: dict, job: dict, settings: dict, out: dict) -> None:
    chain = scene_chain(files, job, settings)
    made = {name: chain[name] for name in settings["products"]}
    for name, value in made.items():
        STORED[name].write(chain, value, files_of(name, out["files"]))
    took = {name: chain.seconds(name) for name in made}
    write_json({name: s for each in took.values() for name, s in each.items() if s > 0}, out["seconds"])


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(
        dict(snakemake.input.items()),
        dict(snakemake.wildcards.items()),
        dict(snakemake.params.items()),
        dict(snakemake.output.items()),
    )
