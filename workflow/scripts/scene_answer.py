"""What one scene asks, and the processor seconds that its parts took."""

import _log

from mammosim.chain.files import scene_chain
from mammosim.io.tables import read_json, read_table, write_json
from mammosim.study.scenes.answers import values
from mammosim.study.scenes.scene import Scene


def main(files: dict, job: dict, settings: dict, out: str) -> None:
    screening = read_table(files["screening"][0]) if files["screening"] else None
    effects = Scene.of(job["scene"], settings["scene"]).modelled(job["model"], screening)
    chain = scene_chain(files, effects, settings)
    took = sum(seconds for path in files["seconds"] for seconds in read_json(path).values())
    found = values(chain, settings["scene"]["asked"])
    write_json({"values": found, "effects": sorted(chain.effects), "seconds": took}, out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(
        dict(snakemake.input.items()),
        dict(snakemake.wildcards.items()),
        dict(snakemake.params.items()),
        snakemake.output[0],
    )
