"""The mesh of a labelled breast."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mammosim.chain.breast import Breast
from mammosim.chain.graph import Inputs
from mammosim.chain.labelled import chest_limits
from mammosim.core.errors import ConfigurationError
from mammosim.core.mesh import TetMesh
from mammosim.core.settings import read, require_positive
from mammosim.core.volume import LabelMap
from mammosim.io import meshes
from mammosim.io.tables import write_table
from mammosim.meshing.body import ElementSize, crop_body, mesh_body
from mammosim.meshing.quality import quality


@dataclass(frozen=True)
class ElementEdges:
    """Edge lengths in mm far from the rib cage, and next to it. Raises MeshError as ElementSize does."""

    breast: float
    chest: float

    def __post_init__(self) -> None:
        _ = self.size

    @property
    def size(self) -> ElementSize:
        """As meshing takes them."""
        return ElementSize(self.breast, self.chest)


@dataclass(frozen=True)
class MeshSettings:
    """`mesh`: size of the elements, and where the modelled tissue ends.

    behind_markers_mm: behind the frontmost chest marker; beyond_markers_mm: above the highest and below the
    lowest one.
    """

    element_mm: ElementEdges
    behind_markers_mm: float
    beyond_markers_mm: float

    def __post_init__(self) -> None:
        require_positive(self, "behind_markers_mm")


def scanned_mesh(labels: LabelMap, chest: np.ndarray, settings: MeshSettings) -> TetMesh:
    """Quadratic tetrahedra of segmented tissue, cut relative to the chest markers (n, 3), scanner frame."""
    beyond = settings.beyond_markers_mm
    cropped = crop_body(
        labels,
        posterior_limit_mm=chest[:, 1].min() + settings.behind_markers_mm,
        height_limits_mm=(chest[:, 2].min() - beyond, chest[:, 2].max() + beyond),
    )
    return mesh_body(cropped, size=settings.element_mm.size)


def mesh(inputs: Inputs) -> TetMesh:
    """The body, common frame; without chest markers cut where its shape says that the breasts end."""
    breast: Breast = inputs["breast"]
    chest = breast.fiducials.of_kind("chest")
    chest = chest if len(chest) else chest_limits(breast.labels, breast.fiducials)
    scanned = scanned_mesh(breast.labels, chest, read(MeshSettings, inputs.setting("mesh"), "mesh"))
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
