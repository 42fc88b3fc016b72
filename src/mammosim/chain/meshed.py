"""A labelled breast as a mesh."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from mammosim.chain.breast import Breast
from mammosim.chain.graph import Inputs
from mammosim.chain.labelled import chest_limits
from mammosim.core.errors import ConfigurationError
from mammosim.core.mesh import TetMesh
from mammosim.core.volume import LabelMap
from mammosim.io import meshes
from mammosim.io.tables import write_table
from mammosim.meshing.body import ElementSize, crop_body, mesh_body
from mammosim.meshing.quality import quality


def scanned_mesh(labels: LabelMap, chest: np.ndarray, settings: Mapping[str, Any]) -> TetMesh:
    """Quadratic tetrahedra of segmented tissue, cut relative to the chest markers (n, 3), scanner frame.

    settings: element_mm {breast, chest}, behind_markers_mm and beyond_markers_mm.
    """
    beyond = settings["beyond_markers_mm"]
    cropped = crop_body(
        labels,
        posterior_limit_mm=chest[:, 1].min() + settings["behind_markers_mm"],
        height_limits_mm=(chest[:, 2].min() - beyond, chest[:, 2].max() + beyond),
    )
    size = settings["element_mm"]
    return mesh_body(cropped, size=ElementSize(size["breast"], size["chest"]))


def mesh(inputs: Inputs) -> TetMesh:
    """The body, common frame; without chest markers cut where its shape says that the breasts end."""
    breast: Breast = inputs["breast"]
    chest = breast.fiducials.of_kind("chest")
    chest = chest if len(chest) else chest_limits(breast.labels, breast.fiducials)
    scanned = scanned_mesh(breast.labels, chest, inputs.setting("mesh"))
    return scanned.moved_to(np.ascontiguousarray(breast.to_reference(scanned.points)))


def save_mesh(mesh: TetMesh, files: Mapping[str, str], job: Mapping[str, str]) -> None:
    """The mesh, and the quality of its cells."""
    table = quality(mesh)
    write_table(table.assign(**job)[[*job, *table.columns]], files["quality"])
    meshes.write_mesh(mesh, files["mesh"])


def load_mesh(files: Mapping[str, str]) -> TetMesh:
    """What save_mesh wrote."""
    return meshes.read_mesh(files["mesh"])


def reference_mesh(inputs: Inputs) -> TetMesh:
    """Raises ConfigurationError: it is the mesh of another position, and made by the chain of that one."""
    raise ConfigurationError("the mesh of the reference position was not given to the chain")


load_reference_mesh = load_mesh
