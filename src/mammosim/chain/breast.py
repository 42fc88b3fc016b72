"""One breast as its images gave it, before anything is modelled."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from mammosim.chain.configuration import gravity_vector
from mammosim.core.fiducials import Fiducials
from mammosim.core.mesh import TetMesh
from mammosim.core.rigid import RigidTransform
from mammosim.core.volume import LabelMap
from mammosim.io.fiducials import read_fiducials
from mammosim.io.images import read_labels
from mammosim.io.transforms import read_transform
from mammosim.meshing.body import ElementSize, crop_body, mesh_body


@dataclass(frozen=True)
class Breast:
    """labels and fiducials in the scanner frame; to_reference: from there into the common frame.

    gravity (3,): unit vector of the measured position, common frame; side: left or right; names: of the
    random streams of its photons and noise, beginning with the seed of the study.
    """

    labels: LabelMap
    fiducials: Fiducials
    to_reference: RigidTransform
    gravity: np.ndarray
    side: str
    names: tuple[str | int, ...] = ()

    @property
    def nipple(self) -> np.ndarray:
        """Where its nipple was measured (3,) mm, scanner frame."""
        return self.fiducials.point(f"nipple_{self.side}")


def read_breast(
    files: Mapping[str, str], gravity: str, *, side: str, names: tuple[str | int, ...] = ()
) -> Breast:
    """The breast of the files labels, fiducials (scanner frame) and transform; gravity: 'x y z', scanner."""
    to_reference = read_transform(files["transform"])
    return Breast(
        read_labels(files["labels"]),
        read_fiducials(files["fiducials"]),
        to_reference,
        to_reference.R @ gravity_vector(gravity),
        side,
        names,
    )


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
