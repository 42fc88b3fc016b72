"""What every trial of accuracy shares: the chain at today's settings, made once and kept in files."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from mammosim.io.images import read_labels, write_labels
from mammosim.io.meshes import read_mesh, read_point_data, write_mesh
from mammosim.io.tables import read_json, read_table, write_json, write_table
from mammosim.study.breast import read_breast
from mammosim.study.chain import Chain
from mammosim.study.knobs import Value
from mammosim.study.pressed import Pressed
from mammosim.study.products_images import read_imaged
from mammosim.study.products_xray import Voxels
from mammosim.study.quantities import quantities
from mammosim.study.trial import MECHANICS, OK, Start, numbered, peak_memory_mb

TODAY = Value("today", {}, today=True)
TABLES = ("path", "cells", "faces", "amounts", "thickness")  # of study.pressed.Pressed
CHAIN = "chain"  # in the place of a knob, the row of the whole chain


def start_of(files: Mapping[str, str], given: Mapping[str, Any]) -> Start:
    """The breast of the files of study.products_images and study.breast, as in the study.

    given: seed, volunteer, position, side, gravity, settings, effects.
    """
    seed, volunteer, position, side = (given[name] for name in ("seed", "volunteer", "position", "side"))
    scan, breast = (seed, volunteer, position), (seed, volunteer, side)
    return Start(
        read_imaged(files, given["gravity"], side=side, names=scan, breast_names=breast),
        read_breast(files, given["gravity"], side=side, names=breast),
        given["settings"],
        frozenset(given["effects"]),
    )


def made_today(start: Start, names: Sequence[str]) -> tuple[Chain, dict[str, float], pd.DataFrame]:
    """The chain at today's settings, the seconds of its products with those of the images, and a row each.

    names: of quantities. What follows the mechanics is made twice, so that no compilation is in its seconds.
    Raises what refuses one of them: without it there is nothing to compare.
    """
    images = replace(start.images(TODAY, 0), made={})
    images.make("breast").required()
    before, rows = images.seconds("breast"), []
    cold = start.chain(TODAY, 0)
    for quantity in quantities(list(names)).values():
        quantity.of(cold)
    done = [name for name in MECHANICS if cold.key(name) in cold.made]
    chain = start.chain(TODAY, 0).given({name: cold[name] for name in done})
    seconds = {name: t for each in done for name, t in cold.seconds(each).items()}
    for name, quantity in quantities(list(names)).items():
        answer = np.atleast_1d(np.asarray(quantity.of(chain), float))
        taken = {n: t for end in quantity.products for n, t in chain.seconds(end).items()}
        seconds |= {n: t for n, t in taken.items() if n not in done}
        taken = {n: seconds[n] for n in taken}
        total = sum(taken.values()) + sum(before.values())
        rows.append({"quantity": name, "repeat": 0} | numbered(answer) | {"seconds": total, "outcome": OK})
    about = {"stage": CHAIN, "knob": CHAIN, "value": TODAY.name, "size": np.nan, "random": False}
    about |= {"today": True, "reference": False, "settings": TODAY.text}
    table = pd.DataFrame(rows).assign(memory_mb=peak_memory_mb())
    return chain, before | seconds, pd.DataFrame(about, index=table.index).join(table)


def write_start(chain: Chain, seconds: Mapping[str, float], folder: str | Path) -> None:
    """The products of a chain up to its phantom and scatter, as far as they were made."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    write_json(dict(seconds), folder / "seconds.json")
    write_mesh(chain["mesh"], folder / "mesh.vtu")
    pressed: Pressed = chain["pressed"]
    shapes = {"loaded": chain["loaded"], "pressed": pressed.points}
    write_mesh(chain["stress_free"], folder / "stress_free.vtu", point_data=shapes)
    for name in TABLES:
        write_table(getattr(pressed, name), folder / f"{name}.csv")
    write_table(pd.DataFrame([pressed.row]), folder / "row.csv")
    write_json(pressed.plates, folder / "plates.json")
    write_labels(chain["phantom"].labels, folder / "phantom.nii.gz")
    write_table(chain["scatter"], folder / "scatter.csv")


def read_start(start: Start, folder: str | Path) -> Start:
    """The start with what write_start kept."""
    folder = Path(folder)
    shape, plates = folder / "stress_free.vtu", read_json(folder / "plates.json")
    row = dict(read_table(folder / "row.csv").iloc[0])
    tables = {name: read_table(folder / f"{name}.csv") for name in TABLES}
    given: dict[str, Any] = {
        "mesh": read_mesh(folder / "mesh.vtu"),
        "stress_free": read_mesh(shape),
        "loaded": read_point_data(shape, "loaded"),
        "pressed": Pressed(read_point_data(shape, "pressed"), **tables, row=row, plates=plates),
        "phantom": Voxels(read_labels(folder / "phantom.nii.gz"), plates),
        "scatter": read_table(folder / "scatter.csv"),
    }
    return replace(start, given=given, seconds=read_json(folder / "seconds.json"))
