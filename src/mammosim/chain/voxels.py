"""The pressed breast as voxels with a lesion, and what was conserved on the way."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from mammosim.chain.breast import Breast
from mammosim.chain.graph import Inputs
from mammosim.chain.phantom import (
    Lesion,
    conservation_table,
    field_box,
    field_grid,
    voxel_breast,
    with_lesion,
)
from mammosim.core.settings import read, require_positive
from mammosim.core.tissues import TissueTable
from mammosim.core.volume import LabelMap
from mammosim.io.images import read_labels, write_labels
from mammosim.io.tables import read_table, write_table

INWARDS = np.array([0.0, 1.0, 0.0])  # prone, scanner frame: from the nipple to the chest wall


@dataclass(frozen=True)
class LesionSettings:
    """`xray.lesion`: a ball of this diameter, its middle this deep behind the nipple."""

    diameter_mm: float
    depth_mm: float

    def __post_init__(self) -> None:
        require_positive(self, "diameter_mm", "depth_mm")


def healthy_phantom(inputs: Inputs) -> LabelMap:
    """The pressed breast in the X-ray field, common frame, without lesion."""
    breast: Breast = inputs["breast"]
    found = inputs["pressed"]
    low, high = field_box(
        breast.side,
        midline_mm=breast.midline_mm,
        chest_wall_mm=found.plates["chest_y_mm"],
        bottom_mm=found.plates["support_z_mm"],
        top_mm=found.plates["paddle_z_mm"],
    )
    grid = field_grid(found.mesh, low, high, voxel_mm=inputs.setting("xray.voxel_mm"))
    skin_mm = inputs.setting("tissues.skin.thickness_mm")
    return voxel_breast(found.mesh, _measured(inputs), breast.labels, grid=grid, skin_mm=skin_mm)


def phantom(inputs: Inputs) -> LabelMap:
    """With the lesion, which lies behind the nipple in the measured position and moves with the tissue."""
    breast: Breast = inputs["breast"]
    given = read(LesionSettings, inputs.setting("xray.lesion"), "xray.lesion")
    lesion = Lesion.behind(breast.nipple, inwards=INWARDS, **vars(given))
    return with_lesion(inputs["healthy_phantom"], inputs["pressed"].mesh, _measured(inputs), lesion)


def _measured(inputs: Inputs) -> np.ndarray:
    """Nodes (n_node, 3) mm where they were measured, scanner frame."""
    found: np.ndarray = inputs["breast"].to_reference.inverse()(inputs["mesh"].points)
    return found


def save_phantom(labels: LabelMap, files: Mapping[str, str], job: Mapping[str, str]) -> None:
    """The labels."""
    write_labels(labels, files["labels"])


def load_phantom(files: Mapping[str, str]) -> LabelMap:
    """What save_phantom wrote."""
    return read_labels(files["labels"])


def conservation(inputs: Inputs) -> pd.DataFrame:
    """Volume and mass from the measured shape to the voxels, see chain.phantom."""
    solids = read(TissueTable, {"tissues": inputs.setting("tissues.tissues")}, "tissues")
    density = {label: tissue.density_g_cm3 for label, tissue in solids.by_label.items()}
    return conservation_table(
        inputs["pressed"].mesh,
        _measured(inputs),
        inputs["breast"].labels,
        inputs["healthy_phantom"],
        density_g_cm3=density,
    )


def save_conservation(table: pd.DataFrame, files: Mapping[str, str], job: Mapping[str, str]) -> None:
    write_table(table.assign(**job)[[*job, *table.columns]], files["rows"])


def load_conservation(files: Mapping[str, str]) -> pd.DataFrame:
    return read_table(files["rows"])
