"""What one scene asks, and the processor seconds that all that it is made of took."""

import _log

from mammosim.chain.files import chain_of
from mammosim.io.plain import read_plain
from mammosim.io.tables import read_json, write_json
from mammosim.study.scenes.answers import seconds, values
from mammosim.study.scenes.scene import Scene


def main(files: dict, job: dict, settings: dict, out: str) -> None:
    screening = read_plain(files["screening"][0]) if files["screening"] else None
    effects = Scene.of(job["scene"], settings["scene"]).modelled(job["model"], screening)
    chain = chain_of(settings["given"], files).with_effects(effects)
    asked = settings["scene"]["asked"]
    found = values(chain, asked)
    took = sum(s for path in files["took"] for s in read_json(path).values()) + seconds(chain, asked)
    write_json({"values": found, "effects": sorted(effects), "seconds": took}, out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(
        dict(snakemake.input.items()),
        dict(snakemake.wildcards.items()),
        dict(snakemake.params.items()),
        snakemake.output[0],
    )
