"""Every scene's answer beside that of the full model, every decision, and a loud word where they disagree."""

import logging
import sys

import _log
import pandas as pd

from mammosim.io.atomic import replacing
from mammosim.io.tables import read_commented, read_json, read_table, write_json, write_table
from mammosim.study.accuracy.presets import errors_at
from mammosim.study.scenes.screening import COLUMNS, JOINT
from mammosim.study.scenes.summary import numbers, outside, rows


def main(files: dict, settings: dict, out: dict) -> None:
    scenes, measured = settings["scenes"], read_commented(files["measured"])
    took = {name: s for path in files["seconds"] for name, s in read_json(path).items()}
    pairs = zip(files["answers"][::2], files["answers"][1::2], strict=True)
    found = []
    for (name, values), pair in zip(scenes.items(), pairs, strict=True):
        errors = errors_at(measured, settings["settings"][name], values["asked"])
        answers = rows(
            name, values["asked"], *map(read_json, pair), numerical=errors, screening_s=took.get(name, 0.0)
        )
        found.append(pd.DataFrame(answers).assign(accuracy=settings["accuracy"][name]))
    table = pd.concat(found, ignore_index=True)
    effects, joint = together(files["effects"], COLUMNS), together(files["joint"], JOINT)
    write_table(table, out["scenes"])
    write_table(effects, out["effects"])
    write_table(joint, out["interactions"])
    write_json(numbers(table, effects), out["numbers"])
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
    tables = [pd.DataFrame(columns=columns), *map(read_table, paths)]
    return pd.concat([each for each in tables if len(each)] or tables[:1], ignore_index=True)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(dict(snakemake.input.items()), dict(snakemake.params.items()), dict(snakemake.output.items()))
