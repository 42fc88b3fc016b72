"""Registration and segmentation of rendered volunteers, whose motion and tissues are known."""

from dataclasses import dataclass

import numpy as np
import pytest

from mammosim.core.fiducials import Fiducials
from mammosim.core.rigid import RigidTransform
from mammosim.core.volume import Image, LabelMap, grid_around
from mammosim.digital.anatomy import make_anatomy
from mammosim.digital.annotator import Painting, clicked, strokes
from mammosim.digital.body import AtRest
from mammosim.digital.loading import motion
from mammosim.digital.patient import VirtualPatient
from mammosim.digital.signal import Scan, render, truth_labels
from mammosim.imaging.markers import chest_markers
from mammosim.imaging.overlap import dice
from mammosim.imaging.registration import register, transform_error
from mammosim.imaging.segmentation import Settings, segment

SPACING_MM = 4.0
SCAN = Scan(
    echo_time_ms=100, repetition_time_ms=4000, adipose=600, bias=0.15, noise=0.02, subsamples=2, marker_mm=7
)
WOMAN = {
    "seed": 1,
    "chest": {
        "centre_y_mm": 60,
        "semi_axis_x_mm": 140,
        "semi_axis_y_mm": 100,
        "muscle_mm": 8,
        "fat_mm": 7,
        "region_back_mm": 40,
        "region_half_height_mm": 100,
    },
    "breast": {
        "base_radius_mm": 58,
        "projection_mm": 38,
        "side_mm": 72,
        "lateral_deg": 15,
        "inferior_deg": 5,
        "fold_mm": 14,
        "nipple_mm": 4.5,
        "right_scale": 0.97,
    },
    "gland": {"fraction": 0.22, "front": 0.6, "cover_mm": 3.0, "wave_mm": 12.0},
    "skin": {"mean_mm": 1.45, "variation_mm": 0.4},
}


@dataclass(frozen=True)
class Scanned:
    """One session: the image, what was clicked, the tissues and the motion behind it."""

    image: Image
    clicks: Fiducials
    labels: LabelMap
    moved: RigidTransform


@pytest.fixture(scope="module")
def sessions() -> tuple[Scanned, Scanned]:
    """The same woman scanned twice, turned by up to 3 degrees and shifted by up to 6 mm each time."""
    anatomy = make_anatomy(VirtualPatient.read(WOMAN))
    grid = grid_around(np.array([-180.0, -120, -108]), np.array([180.0, 72, 108]), SPACING_MM)
    return tuple(_scan(anatomy, grid, name) for name in ("first", "second"))


def _scan(anatomy, grid, name) -> Scanned:
    moved = motion(name, largest_deg=3, largest_mm=6, stream=(1,))
    body = AtRest(anatomy, moved)
    return Scanned(
        render(body, grid, scan=SCAN, stream=(1, name)),
        clicked(body, scan=SCAN, error_mm=0.5, stream=(1, name)),
        truth_labels(body, grid, scan=SCAN),
        moved,
    )


def test_the_motion_is_recovered_to_an_eighth_of_a_voxel(sessions) -> None:
    fixed, moving = sessions
    fixed_markers, moving_markers = (chest_markers(s.image, s.clicks).of_kind("chest") for s in sessions)
    found = register(fixed.image, moving.image, fixed_markers, moving_markers)
    error = transform_error(
        found.refined, fixed.moved.after(moving.moved.inverse()), moving.clicks.of_kind("nipple")
    )
    # Ten thousands of voxels inside the chest fix six numbers; interpolating 4 mm voxels limits them to a
    # tenth of one. 0.5 mm at the 100 mm from the chest's middle to its border are 0.3 degrees.
    assert error["max_mm"] < SPACING_MM / 8
    assert error["rotation_deg"] < 0.3


def test_tissues_are_found_from_a_few_strokes(sessions) -> None:
    scan, _ = sessions
    painted = strokes(scan.labels, Painting((-24.0, 0.0, 24.0), per_tissue=4, steps=12), stream=(1,))
    values = dice(segment(scan.image, painted, settings=Settings(trees=30)).labels, scan.labels)
    overlap = values.set_index("tissue")["dice"]
    # Layers of t = 16 mm (what moves) and 8 mm (muscle) each face h / 4 = 1 mm off: 1 - h / (4 t).
    assert overlap["deformable"] > 1 - 1 / 16
    assert overlap["muscle"] > 1 - 1 / 8
    assert overlap["glandular"] > 0.8
    assert overlap["thorax"] > 0.97
