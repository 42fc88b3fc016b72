"""What one scene asks, and the processor seconds that all that it is made of took."""

from dataclasses import asdict

import _log
import _stage

from mammosim.chain.files import chain_of
from mammosim.core.settings import read
from mammosim.io.plain import read_plain
from mammosim.io.tables import read_json, write_json
from mammosim.study.scenes.answers import Answered, seconds, values
from mammosim.study.scenes.scene import Scene


def main(files: dict, job: dict, settings: dict, out: str) -> None:
    screening = read_plain(files["screening"][0]) if files["screening"] else None
    scene = read(Scene, settings["scene"], f"scene {job['scene']}")
    effects = scene.modelled(job["model"], screening)
    chain = chain_of(settings["given"], files).with_effects(effects)
    found = values(chain, scene.asked)
    took = sum(s for path in files["took"] for s in read_json(path).values()) + seconds(chain, scene.asked)
    write_json(asdict(Answered(found, tuple(sorted(effects)), took)), out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(
        dict(snakemake.input.items()),
        dict(snakemake.wildcards.items()),
        _stage.settings(snakemake),
        snakemake.output[0],
    )
