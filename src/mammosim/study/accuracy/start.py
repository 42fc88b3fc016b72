"""What every trial of accuracy shares: the chain at today's settings, made once and kept in files."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from mammosim.chain.graph import Chain
from mammosim.chain.quantities import quantities
from mammosim.chain.stages import STAGES
from mammosim.study.accuracy.presets import CHAIN
from mammosim.study.accuracy.trial import OK, numbered, peak_memory_mb

TODAY = "today"
KEPT = ("transform", "labels", "mesh", "stress_free", "loaded", "standard_path", "pressed", "phantom",
        "field", "spectrum", "scatter")  # fmt: skip


def made_today(measured: Chain, names: Sequence[str]) -> tuple[Chain, pd.DataFrame]:
    """The chain of what was measured at today's settings, and a row per quantity with the seconds of all.

    names: of quantities. All is made twice, so that no compilation is in its seconds.
    Raises what refuses one of them: without it there is nothing to compare.
    """
    asked = quantities(list(names))
    for _ in range(2):
        chain = replace(measured, made={})
        answers = {name: quantity.of(chain) for name, quantity in asked.items()}
    rows = []
    for name, quantity in asked.items():
        taken = {n: t for end in quantity.products for n, t in chain.seconds(end).items()}
        answer = numbered(np.atleast_1d(np.asarray(answers[name], float)))
        rows.append(
            {"quantity": name, "repeat": 0} | answer | {"seconds": sum(taken.values()), "outcome": OK}
        )
    about = {"stage": CHAIN, "knob": CHAIN, "value": TODAY, "size": np.nan, "random": False}
    about |= {"today": True, "reference": False, "settings": "{}"}
    table = pd.DataFrame(rows).assign(memory_mb=peak_memory_mb())
    return chain, pd.DataFrame(about, index=table.index).join(table)


def write_start(chain: Chain, folder: str | Path) -> None:
    """The products KEPT of a chain, as far as they were made for an answer."""
    Path(folder).mkdir(parents=True, exist_ok=True)
    for name in KEPT:
        made = chain.made.get(chain.key(name)) if name in chain.stages else None
        if made is not None and made.refusal is None:
            chain.stages[name].save(made.value, _paths(folder, name, beside=True), {})


def start_files(folder: str | Path) -> dict[str, dict[str, str]]:
    """What write_start kept: product -> file -> path."""
    paths = {name: _paths(folder, name) for name in KEPT}
    return {
        name: files for name, files in paths.items() if all(Path(path).exists() for path in files.values())
    }


def _paths(folder: str | Path, name: str, *, beside: bool = False) -> dict[str, str]:
    files = STAGES[name].files
    endings: Mapping[str, str] = (
        {} if files is None else {**files.endings, **(files.beside if beside else {})}
    )
    return {file: str(Path(folder) / f"{name}_{file}{ending}") for file, ending in endings.items()}
