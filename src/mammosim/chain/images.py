"""From raw images to a labelled breast: the motion into the common frame, and tissue labels."""

import logging
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from mammosim.chain.breast import Breast
from mammosim.chain.conditions import finds_markers, is_labelled, is_marked, is_moved, is_painted
from mammosim.chain.given_labels import LabelSettings, prepared
from mammosim.chain.graph import Inputs
from mammosim.chain.labelled import nipples
from mammosim.core.errors import ConfigurationError
from mammosim.core.fiducials import Fiducials
from mammosim.core.positions import gravity_vector
from mammosim.core.rigid import IDENTITY, RigidTransform
from mammosim.core.rng import seed_of
from mammosim.core.settings import looked_up, read
from mammosim.core.volume import Image, LabelMap
from mammosim.imaging import registration as rigid
from mammosim.imaging import segmentation as tissues
from mammosim.imaging.markers import worn_on_chest
from mammosim.imaging.segmentation import Segmentation
from mammosim.imaging.unmarked import register_unmarked
from mammosim.io.fiducials import read_fiducials, write_fiducials
from mammosim.io.images import read_image, read_labels, write_image, write_labels
from mammosim.io.label_maps import CodedMap, read_label_map
from mammosim.io.strokes import read_strokes
from mammosim.io.tables import write_table
from mammosim.io.transforms import read_transform, write_transform

log = logging.getLogger(__name__)

STEPS = list(rigid.COLUMNS)
# ASSUME: breasts hang, and nipples show in the labels, where gravity points to the front within 60 degrees.
HANGING = -0.5
NO_POINTS = Fiducials((), (), np.empty((0, 3)))
LEARNT = ("classifier", "trees", "voxel_mm", "neighbourhood_mm", "smoothing")


def measured(inputs: Inputs) -> Any:
    """Raises ConfigurationError: a scan, strokes, labels and listed fiducials are given, and not computed."""
    raise ConfigurationError("a scan, strokes, labels and fiducials are measured: give them to the chain")


scan = strokes = listed = given_labels = reference_fiducials = measured


def load_scan(files: Mapping[str, str]) -> Image:
    """The image of a position, scanner frame."""
    return read_image(files["scan"])


def load_strokes(files: Mapping[str, str]) -> pd.DataFrame:
    """Columns x_mm, y_mm, z_mm, tissue."""
    return read_strokes(files["strokes"])


def load_given_labels(files: Mapping[str, str]) -> CodedMap:
    """The label map that a person gave in the place of a segmentation, codes as they are."""
    return read_label_map(files["labels"])


def load_fiducials(files: Mapping[str, str]) -> Fiducials:
    """Markers and nipples."""
    return read_fiducials(files["fiducials"])


def save_fiducials(fiducials: Fiducials, files: Mapping[str, str], job: Mapping[str, str]) -> None:
    """Write markers and nipples, also as 3D Slicer reads them."""
    write_fiducials(fiducials, files["fiducials"])
    write_fiducials(fiducials, files["markups"])


load_listed = load_reference_fiducials = load_moved_fiducials = load_fiducials
save_moved_fiducials = save_fiducials


def fiducials(inputs: Inputs) -> Fiducials:
    """The list of a person, scanner frame; its chest markers as found in the image where asked for.

    Without a list the nipples, as found in the labels where the breasts hang, else no point at all.
    """
    if not is_marked(inputs):
        return nipples(inputs["labels"]) if hangs(inputs.subject.gravity) else NO_POINTS
    listed: Fiducials = inputs["listed"]
    if "reference" not in inputs.subject.has:
        return listed
    return worn_on_chest(listed, inputs["scan"] if finds_markers(inputs) else None)


def hangs(gravity: str) -> bool:
    """Whether breasts hang to the front under gravity 'x y z' of the scanner frame."""
    return float(gravity_vector(gravity)[1]) < HANGING


@dataclass(frozen=True)
class Moved:
    """The motion into the common frame; the steps by which it was found, none for the reference itself."""

    motion: RigidTransform
    steps: pd.DataFrame


def registration(inputs: Inputs) -> Moved:
    """Markers first, then the rib cage's image; without chest markers in both the rib cage alone."""
    if not inputs.subject.moves:
        return Moved(IDENTITY, pd.DataFrame(columns=STEPS))
    settings = looked_up(rigid.Settings, inputs.setting, "registration")
    fixed, moving = (inputs[name].of_kind("chest") for name in ("reference_fiducials", "fiducials"))
    images = inputs["reference_scan"], inputs["scan"]
    if len(fixed) and len(moving):
        found = rigid.register(*images, fixed, moving, settings=settings)
    else:
        found = register_unmarked(*images, settings=settings)
    return Moved(found.refined, found.table)


def transform(inputs: Inputs) -> Moved:
    """From the scanner frame of the measured position into the common frame."""
    found: Moved = inputs["registration"]
    return found


def save_transform(found: Moved, files: Mapping[str, str], job: Mapping[str, str]) -> None:
    """Write the motion, and the steps by which it was found."""
    write_transform(found.motion, files["transform"])
    write_table(found.steps.assign(**job)[[*job, *found.steps.columns]], files["steps"])


def load_transform(files: Mapping[str, str]) -> Moved:
    """Read the motion, without its steps."""
    return Moved(read_transform(files["transform"]), pd.DataFrame(columns=STEPS))


def moved_scan(inputs: Inputs) -> Image:
    """The image in the grid of the reference's."""
    return rigid.resample(inputs["scan"], inputs["transform"].motion, inputs["reference_scan"].grid)


def save_moved_scan(image: Image, files: Mapping[str, str], job: Mapping[str, str]) -> None:
    """Write the moved image."""
    write_image(image, files["scan"])


def moved_fiducials(inputs: Inputs) -> Fiducials:
    """Markers and nipples in the common frame."""
    given, motion = inputs["fiducials"], inputs["transform"].motion
    return Fiducials(given.names, given.kinds, motion(given.points))


def segmentation(inputs: Inputs) -> Segmentation:
    """Tissue labels and the probability of gland, scanner frame; from strokes where they are given."""
    given = {name: inputs.setting(f"segmentation.{name}") for name in LEARNT}
    given["seed"] = seed_of(*inputs.subject.scan, "segment")
    settings = read(tissues.Settings, given, "segmentation")
    painted = inputs["strokes"] if is_painted(inputs) else None
    return tissues.segment(inputs["scan"], painted, settings=settings)


def taken_labels(inputs: Inputs) -> LabelMap:
    """Tissue labels of the map that was given, scanner frame; what was mended in it is logged."""
    taken = prepared(inputs["given_labels"], looked_up(LabelSettings, inputs.setting, "labels"))
    for note in taken.notes:
        log.info(note)
    return taken.labels


def labels(inputs: Inputs) -> LabelMap:
    """Tissue labels of the image, or in its place, scanner frame."""
    found: LabelMap = inputs["taken_labels"] if is_labelled(inputs) else inputs["segmentation"].labels
    return found


def save_labels(labels: LabelMap, files: Mapping[str, str], job: Mapping[str, str]) -> None:
    """Write the labels."""
    write_labels(labels, files["labels"])


def load_labels(files: Mapping[str, str]) -> LabelMap:
    """Read the labels."""
    return read_labels(files["labels"])


def gland_probability(inputs: Inputs) -> Image:
    """The probability of each voxel to be gland."""
    found: Image = inputs["segmentation"].probability
    return found


def save_gland_probability(image: Image, files: Mapping[str, str], job: Mapping[str, str]) -> None:
    """Write the probability."""
    write_image(image, files["probability"])


def breast(inputs: Inputs) -> Breast:
    """The measured breast, of labels, markers and motion."""
    motion: RigidTransform = inputs["transform"].motion if is_moved(inputs) else IDENTITY
    gravity: np.ndarray = motion.R @ gravity_vector(inputs.subject.gravity)
    return Breast(inputs["labels"], inputs["fiducials"], motion, gravity, inputs.subject.side)
