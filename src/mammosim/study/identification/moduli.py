"""The moduli of one body by side and tissue: what a fit finds, and the body that has them."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace

import numpy as np
import pandas as pd

from mammosim.core.errors import ConfigurationError
from mammosim.core.labels import Label
from mammosim.core.mesh import TetMesh
from mammosim.core.tissues import Tissue
from mammosim.mechanics.body import SIDES, Body, Skin, sided_body

# What a body of this study has moduli for; fascia is not among them, see study.identification.problem.
TISSUES = ("adipose", "glandular", "skin", "muscle")
SOLIDS = tuple(tissue for tissue in TISSUES if tissue != "skin")
KEYS = tuple((side, tissue) for side in SIDES for tissue in TISSUES)


@dataclass(frozen=True)
class Materials:
    """What a body is made of, as a file of config/tissues says: its solids by name, and its skin.

    Raises ConfigurationError when adipose, glandular or muscle is lacking, or there is another one.
    """

    tissues: Mapping[str, Tissue]
    skin: Skin

    def __post_init__(self) -> None:
        if set(self.tissues) != set(SOLIDS):
            raise ConfigurationError(f"tissues has {', '.join(self.tissues)}; write {', '.join(SOLIDS)}")

    def setting(self) -> dict[str, dict[str, object]]:
        """As the plain values of a file of config/tissues: {tissues: {adipose: {...}, ...}, skin: {...}}."""
        skin = asdict(self.skin)
        del skin["boundary"]
        return {"tissues": {name: asdict(of) for name, of in self.tissues.items()}, "skin": skin}


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
    def of_draw(cls, draw: Mapping[str, float]) -> "Moduli":
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
        assumed: Materials,
        *,
        middle_mm: float,
        poisson_ratio: float | None = None,
    ) -> Body:
        """The body of `mesh`, and of its cells in any shape; sides are told apart at x = middle_mm.

        assumed: of which everything but the moduli is taken; poisson_ratio: of all solids, in place of the
        assumed ones.
        """
        own = {side: self.materials(assumed, side, poisson_ratio=poisson_ratio) for side in SIDES}
        by_label = {
            side: {Label[name.upper()]: tissue for name, tissue in of.tissues.items()}
            for side, of in own.items()
        }
        return sided_body(mesh, by_label, {side: of.skin for side, of in own.items()}, middle_mm=middle_mm)

    def materials(self, assumed: Materials, side: str, *, poisson_ratio: float | None = None) -> Materials:
        """The materials of one side; see body."""
        tissues = {
            name: replace(
                tissue,
                youngs_modulus_kpa=self.kpa[side, name],
                poisson_ratio=tissue.poisson_ratio if poisson_ratio is None else poisson_ratio,
            )
            for name, tissue in assumed.tissues.items()
        }
        return Materials(tissues, replace(assumed.skin, youngs_modulus_kpa=self.kpa[side, "skin"]))
