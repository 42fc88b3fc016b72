"""Which effects the scenes of one breast and load call for, on the coarse model."""

import time

import _log
import _stage
import pandas as pd

from mammosim.chain.files import chain_of
from mammosim.core.settings import read
from mammosim.io.tables import write_json, write_table
from mammosim.study.scenes.answers import answers
from mammosim.study.scenes.scene import Scene
from mammosim.study.scenes.screening import Rule, Screening


def main(files: dict, settings: dict, out: dict) -> None:
    chain = chain_of(settings["given"], files)
    rule, tables, took = read(Rule, settings["rule"], "scenes"), [], {}
    for scene in (read(Scene, given, f"scene {name}") for name, given in settings["scenes"].items()):
        began = time.process_time()
        evaluated = answers(chain, scene.asked)
        screening = Screening(scene.name, scene.full, scene.needed, scene.asked, evaluated, rule)
        tables.append(screening.tables())
        took[scene.name] = time.process_time() - began
    effects, joint = map(pd.concat, zip(*tables, strict=True))
    write_table(effects, out["effects"])
    write_table(joint, out["joint"])
    write_json(took, out["seconds"])


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(dict(snakemake.input.items()), _stage.settings(snakemake), dict(snakemake.output.items()))
