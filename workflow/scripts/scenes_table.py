"""Every scene's answer beside that of the full model, every decision, and a loud word where they disagree."""

import logging
import sys

import _log
import _stage
import pandas as pd

from mammosim.core.settings import read
from mammosim.io.atomic import replacing
from mammosim.io.tables import read_commented, read_json, read_table, write_numbers, write_table
from mammosim.study.accuracy.presets import errors_at
from mammosim.study.scenes.answers import Answered, numbers, outside, rows
from mammosim.study.scenes.scene import Scene
from mammosim.study.scenes.screening import COLUMNS, JOINT


def main(files: dict, settings: dict, out: dict) -> None:
    scenes = [read(Scene, given, f"scene {name}") for name, given in settings["scenes"].items()]
    measured = read_commented(files["measured"])
    took = {name: s for path in files["seconds"] for name, s in read_json(path).items()}
    answered = [read(Answered, read_json(path), path) for path in files["answers"]]
    found = []
    for scene, screened, full in zip(scenes, answered[::2], answered[1::2], strict=True):
        errors = errors_at(measured, settings["settings"][scene.name], scene.asked)
        answers = rows(scene, screened, full, numerical=errors, screening_s=took.get(scene.name, 0.0))
        found.append(pd.DataFrame(answers).assign(accuracy=settings["accuracy"][scene.name]))
    table = pd.concat(found, ignore_index=True)
    effects, joint = together(files["effects"], COLUMNS), together(files["joint"], JOINT)
    write_table(table, out["scenes"])
    write_table(effects, out["effects"])
    write_table(joint, out["interactions"])
    write_numbers(numbers(table, effects), out["numbers"])
    write_variants(settings["variants"], out["variants"])
    for line in outside(table):
        logging.getLogger("mammosim").error(line)
        sys.stderr.write(f"{line}\n")


def write_variants(variants: dict[str, list[str]], out: str) -> None:
    """Which scenes and models ask for the files of each variant of the chain."""
    rows = [
        {"files": stem, "asked_by": "; ".join(dict.fromkeys(by))} for stem, by in sorted(variants.items())
    ]
    with replacing(out) as temporary:
        pd.DataFrame(rows, columns=["files", "asked_by"]).to_csv(temporary, sep="\t", index=False)


def together(paths: list[str], columns: list[str]) -> pd.DataFrame:
    """Tables below each other; only the columns where all are empty."""
    tables = [pd.DataFrame(columns=columns), *(read_table(path, may_be_empty=True) for path in paths)]
    return pd.concat([each for each in tables if len(each)] or tables[:1], ignore_index=True)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(dict(snakemake.input.items()), _stage.settings(snakemake), dict(snakemake.output.items()))
