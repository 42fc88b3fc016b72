"""Whether a detector holds a pressed breast is known from its voxels alone."""

import numpy as np
import pytest
import yaml

from mammosim.chain.beam import HELD, MAMMOGRAM, TOMOSYNTHESIS, Mammography, Scanner, field_rows, require_held
from mammosim.core.errors import ConfigurationError, MissingResult
from mammosim.core.labels import Label
from mammosim.core.settings import read
from mammosim.core.volume import LabelMap, grid_around

GEOMETRY = {
    "source_to_detector_mm": 650.0, "support_to_detector_mm": 20.0, "pixel_mm": 1.0,
    "field_mm": {"depth": 100.0, "width": 200.0},
}  # fmt: skip
MAMMOGRAPHY = read(Mammography, GEOMETRY, "xray")
JOB = {"volunteer": "large", "side": "left", "strategy": "standard", "moduli": "gravity"}


def rows(width_mm: float):
    """Of a block of fat, so wide, 60 mm deep and 40 mm thick."""
    grid = grid_around(np.array([-width_mm / 2, -60.0, 0.0]), np.array([width_mm / 2, 0.0, 40.0]), 4.0)
    labels = LabelMap(grid, np.full(grid.shape, Label.ADIPOSE, np.uint8))
    scanner = Scanner("victre", 1.0)
    found = field_rows(labels, chest_y_mm=0.0, mammography=MAMMOGRAPHY, scanner=scanner)
    return found.assign(**JOB)


def test_the_room_of_a_block_follows_from_similar_triangles():
    """From straight above, a top at 40 + 20 mm is 650/590 times as wide."""
    row = rows(120.0).set_index("view").loc[MAMMOGRAM]
    assert row.outcome == HELD
    assert row.shadow_width_mm == pytest.approx(120 * 650 / 590)
    assert row.room_mm == pytest.approx(100 - 60 * 650 / 590)
    require_held(rows(120.0), MAMMOGRAM)
    require_held(rows(120.0), TOMOSYNTHESIS)


def test_the_published_detectors_hold_both_women_with_10_mm_to_spare(repository):
    """Between plates the volume of half an ellipsoid, 2/3 pi R^2 p, is half a disc, pi r^2 t / 2."""
    config = yaml.safe_load((repository / "config/default.yaml").read_text())
    for woman in config["volunteers"]:
        breast = config["digital"]["women"][woman]["breast"]
        t = config["compression"]["thickness_mm"][woman]
        r = np.sqrt(4 / 3 * breast["base_radius_mm"] ** 2 * breast["projection_mm"] / t)
        grid = grid_around(np.array([-r, -r, 0.0]), np.array([r, 0.0, t]), 2.0)
        x, y, _ = np.moveaxis(grid.centres().reshape(*grid.shape, 3), -1, 0)
        values = np.where(np.hypot(x, y) < r, np.uint8(Label.ADIPOSE), np.uint8(Label.AIR))
        mammography = read(Mammography, {key: config["xray"][key] for key in GEOMETRY}, "xray")
        scanner = Scanner(config["xray"]["tomosynthesis"]["system"], 1.0)
        held = field_rows(LabelMap(grid, values), chest_y_mm=0.0, mammography=mammography, scanner=scanner)
        assert held.outcome.tolist() == [HELD] * 2, woman
        assert held.room_mm.min() > 10, woman


def test_a_breast_may_fit_one_detector_and_not_the_other():
    """One shadow of 180 mm fits into 200 mm; over the whole arc it needs more than 255 mm."""
    found = rows(180.0)
    require_held(found, MAMMOGRAM)
    with pytest.raises(
        MissingResult, match=r"^tomosynthesis large left standard gravity: .* leaves .*victre"
    ):
        require_held(found, TOMOSYNTHESIS)
    assert found.set_index("view").room_mm.isna().tolist() == [False, True]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"support_to_detector_mm": 650.0}, r"xray: support_to_detector_mm = 650 is outside \[0, 650\)"),
        ({"pixel_mm": 0.0}, r"xray: pixel_mm = 0 is outside \(0, inf\)"),
        ({"field_mm": {"depth": 100.0}}, r"xray\.field_mm lacks width"),
        ({"field_mm": {"depth": 100.0, "width": -1.0}}, r"xray\.field_mm: width = -1 is outside \(0, inf\)"),
        ({"source_to_detector_mm": None}, r"xray\.source_to_detector_mm = None is of type"),
    ],
)
def test_a_geometry_that_cannot_be_is_rejected(change, words):
    with pytest.raises(ConfigurationError, match=words):
        read(Mammography, GEOMETRY | change, "xray")
