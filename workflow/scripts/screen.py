"""Which effects the scenes of one breast and load call for, on the coarse model."""

import time

import _log
import pandas as pd

from mammosim.chain.breast import read_breast
from mammosim.chain.graph import Chain
from mammosim.chain.stages import PRODUCTS
from mammosim.io.tables import write_json, write_table
from mammosim.study.scenes.answers import answers
from mammosim.study.scenes.scene import Scene
from mammosim.study.scenes.screening import Rule, Screening


def main(files: dict, settings: dict, out: dict) -> None:
    values = settings["scenes"]
    first = next(iter(values.values()))
    names = (settings["seed"], first["volunteer"], first["side"], "scenes")
    breast = read_breast(files, settings["gravity"], side=first["side"], names=names)
    chain = Chain(breast, settings["settings"], frozenset(), PRODUCTS)
    tables, took = [], {}
    for scene in (Scene.of(name, given) for name, given in values.items()):
        began = time.process_time()
        evaluated = answers(chain, scene.asked)
        rule = Rule(**settings["rule"])
        screening = Screening(scene.name, scene.full, scene.needed, scene.asked, evaluated, rule)
        tables.append(screening.tables())
        took[scene.name] = time.process_time() - began
    effects, joint = map(pd.concat, zip(*tables, strict=True))
    write_table(effects, out["effects"])
    write_table(joint, out["joint"])
    write_json(took, out["seconds"])


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(dict(snakemake.input.items()), dict(snakemake.params.items()), dict(snakemake.output.items()))
