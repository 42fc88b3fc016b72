"""What every trial of accuracy shares: the chain at today's settings, made once and kept in files."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from mammosim.chain.breast import read_breast
from mammosim.chain.files import STORED
from mammosim.chain.graph import Chain
from mammosim.chain.imaging import read_imaged
from mammosim.chain.quantities import quantities
from mammosim.study.accuracy.knobs import Value
from mammosim.study.accuracy.presets import CHAIN
from mammosim.study.accuracy.trial import OK, Start, numbered, peak_memory_mb

TODAY = Value("today", {}, today=True)
KEPT = ("mesh", "stress_free", "loaded", "pressed", "phantom", "scatter")


def start_of(files: Mapping[str, str], given: Mapping[str, Any]) -> Start:
    """The breast of the files of chain.imaging and chain.breast, as in the study.

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


def made_today(start: Start, names: Sequence[str]) -> tuple[Chain, pd.DataFrame]:
    """The chain at today's settings, and a row per quantity with the seconds of all, images included.

    names: of quantities. All is made twice, so that no compilation is in its seconds.
    Raises what refuses one of them: without it there is nothing to compare.
    """
    asked = quantities(list(names))
    for _ in range(2):
        images = replace(start.images(TODAY, 0), made={})
        images.make("breast").required()
        chain = start.chain(TODAY, 0)
        answers = {name: quantity.of(chain) for name, quantity in asked.items()}
    before = sum(images.seconds("breast").values())
    rows = []
    for name, quantity in asked.items():
        taken = {n: t for end in quantity.products for n, t in chain.seconds(end).items()}
        answer = numbered(np.atleast_1d(np.asarray(answers[name], float)))
        seconds = before + sum(taken.values())
        rows.append({"quantity": name, "repeat": 0} | answer | {"seconds": seconds, "outcome": OK})
    about = {"stage": CHAIN, "knob": CHAIN, "value": TODAY.name, "size": np.nan, "random": False}
    about |= {"today": True, "reference": False, "settings": TODAY.text}
    table = pd.DataFrame(rows).assign(memory_mb=peak_memory_mb())
    return chain, pd.DataFrame(about, index=table.index).join(table)


def write_start(chain: Chain, folder: str | Path) -> None:
    """The products of a chain up to its phantom and scatter, as far as they were made for an answer."""
    for name in KEPT:
        if chain.key(name) in chain.made and chain[name] is not None:
            Path(folder).mkdir(parents=True, exist_ok=True)
            STORED[name].write(chain, chain[name], _paths(folder, name))


def read_start(start: Start, folder: str | Path) -> Start:
    """The start with what write_start kept."""
    paths = {name: _paths(folder, name) for name in KEPT}
    there = {name: files for name, files in paths.items() if Path(files[0]).exists()}
    return replace(start, given={name: STORED[name].read(files) for name, files in there.items()})


def _paths(folder: str | Path, name: str) -> list[str]:
    return [str(Path(folder) / f"{name}{ending}") for ending in STORED[name].endings]
