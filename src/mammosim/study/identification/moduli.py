"""The moduli of one body by side and tissue: what a fit finds, and the body that has them."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from mammosim.core.mesh import TetMesh
from mammosim.core.tissues import tissues_by_label
from mammosim.mechanics.body import SIDES, Body, Skin, sided_body

# What a body of this study has moduli for; fascia is not among them, see study.identification.problem.
TISSUES = ("adipose", "glandular", "skin", "muscle")
KEYS = tuple((side, tissue) for side in SIDES for tissue in TISSUES)


@dataclass(frozen=True)
class Moduli:
    """E [kPa] of every (side, tissue) of KEYS."""

    kpa: Mapping[tuple[str, str], float]

    @classmethod
    def of_rows(cls, table: pd.DataFrame) -> "Moduli":
        """The fitted ones of a table with columns side, tissue, fitted_kpa."""
        rows = table.set_index(["side", "tissue"]).fitted_kpa
        return cls({key: float(rows[key]) for key in KEYS})

    @classmethod
    def of_draw(cls, draw: Mapping[str, Any]) -> "Moduli":
        """Those of one row of a table with columns {side}_{tissue}_kpa."""
        return cls({(side, tissue): float(draw[f"{side}_{tissue}_kpa"]) for side, tissue in KEYS})

    @classmethod
    def of_logarithms(cls, values: np.ndarray) -> "Moduli":
        """From ln E (8,), in the order of KEYS."""
        return cls(dict(zip(KEYS, np.exp(values))))

    def logarithms(self) -> np.ndarray:
        """ln E (8,), in the order of KEYS."""
        return np.log([self.kpa[key] for key in KEYS])

    def row(self) -> dict[str, float]:
        """As columns {side}_{tissue}_kpa."""
        return {f"{side}_{tissue}_kpa": E for (side, tissue), E in self.kpa.items()}

    def body(
        self,
        mesh: TetMesh,
        assumed: Mapping[str, Any],
        *,
        middle_mm: float,
        poisson_ratio: float | None = None,
    ) -> Body:
        """The body of `mesh`, and of its cells in any shape; sides are told apart at x = middle_mm.

        assumed: {tissues: {adipose: {...}, ...}, skin: {...}}, of which everything but the moduli is taken;
        poisson_ratio: of all solids, in place of the assumed ones.
        """
        tissues, skins = {}, {}
        for side in SIDES:
            table = {name: {**part} for name, part in assumed["tissues"].items()}
            for name, part in table.items():
                part["youngs_modulus_kpa"] = self.kpa[side, name]
                if poisson_ratio is not None:
                    part["poisson_ratio"] = poisson_ratio
            tissues[side] = tissues_by_label(table)
            skins[side] = replace(Skin(**assumed["skin"]), youngs_modulus_kpa=self.kpa[side, "skin"])
        return sided_body(mesh, tissues, skins, middle_mm=middle_mm)
