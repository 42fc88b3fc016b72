"""Products of raw images: the motion into the common frame, tissue labels, and the breast they give.

A chain of these begins with Imaged; its breast is what the chain of mechanics and X-rays begins with.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from mammosim.chain.breast import Breast
from mammosim.chain.configuration import gravity_vector
from mammosim.chain.graph import Inputs, Product
from mammosim.core.fiducials import Fiducials
from mammosim.core.rigid import IDENTITY, RigidTransform
from mammosim.core.rng import seed_of
from mammosim.core.volume import Image, LabelMap
from mammosim.imaging import registration, segmentation
from mammosim.io.fiducials import read_fiducials
from mammosim.io.images import read_image
from mammosim.io.tables import read_table


@dataclass(frozen=True)
class Imaged:
    """What was measured of one breast, scanner frame of its position.

    reference: image and chest markers (4, 3) of the position whose frame is common; None where it is this
    one. strokes: x_mm, y_mm, z_mm, tissue; gravity (3,): unit vector; side: left or right; names: of the
    random streams of the images; breast_names: of photons and noise.
    """

    image: Image
    reference: tuple[Image, np.ndarray] | None
    strokes: pd.DataFrame
    fiducials: Fiducials
    gravity: np.ndarray
    side: str
    names: tuple[str | int, ...]
    breast_names: tuple[str | int, ...]


def read_imaged(
    files: Mapping[str, str],
    gravity: str,
    *,
    side: str,
    names: tuple[str | int, ...],
    breast_names: tuple[str | int, ...],
) -> Imaged:
    """Of the files image, strokes, fiducials, reference and reference_fiducials; gravity: 'x y z'."""
    reference = None
    if files["reference"] != files["image"]:
        markers = read_fiducials(files["reference_fiducials"]).of_kind("chest")
        reference = (read_image(files["reference"]), markers)
    return Imaged(
        read_image(files["image"]),
        reference,
        read_table(files["strokes"]),
        read_fiducials(files["fiducials"]),
        gravity_vector(gravity),
        side,
        names,
        breast_names,
    )


def _registration(inputs: Inputs) -> RigidTransform:
    """From the scanner frame of the image into the common frame."""
    seen: Imaged = inputs.subject
    if seen.reference is None:
        return IDENTITY
    image, markers = seen.reference
    settings = registration.Settings(**{name: inputs.setting(f"registration.{name}") for name in PYRAMID})
    moving = seen.fiducials.of_kind("chest")
    return registration.register(image, seen.image, markers, moving, settings=settings).refined


def _segmentation(inputs: Inputs) -> LabelMap:
    """Tissue labels of the image."""
    seen: Imaged = inputs.subject
    given = {name: inputs.setting(f"segmentation.{name}") for name in LEARNT}
    settings = segmentation.Settings(**given, seed=seed_of(*seen.names, "segment"))
    return segmentation.segment(seen.image, seen.strokes, settings=settings).labels


def _breast(inputs: Inputs) -> Breast:
    """The breast in them."""
    seen: Imaged = inputs.subject
    motion = inputs["registration"]
    gravity = motion.R @ seen.gravity
    return Breast(inputs["segmentation"], seen.fiducials, motion, gravity, seen.side, seen.breast_names)


PYRAMID = ("voxel_mm", "smoothing_mm", "iterations", "samples")
LEARNT = ("classifier", "trees", "voxel_mm", "neighbourhood_mm", "smoothing")
PRODUCTS: Mapping[str, Product] = {
    "registration": Product(_registration, reads=tuple(f"registration.{name}" for name in PYRAMID)),
    "segmentation": Product(_segmentation, reads=tuple(f"segmentation.{name}" for name in LEARNT)),
    "breast": Product(_breast, ("registration", "segmentation")),
}
