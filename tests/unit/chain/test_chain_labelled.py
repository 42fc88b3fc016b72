"""What a label map tells: nipples and the chest, where nobody marked them; and labels in the chain."""

from dataclasses import replace

import numpy as np
import pytest

from mammosim.chain.graph import Chain
from mammosim.chain.labelled import chest_limits, nipples, outline_image
from mammosim.chain.stages import STAGES
from mammosim.chain.subject import Subject
from mammosim.core.errors import FiducialError, ImageError
from mammosim.core.labels import Label
from mammosim.core.volume import LabelMap, grid_around
from mammosim.imaging.quality import require_usable
from mammosim.io.images import write_labels

H = 4.0  # mm, of a voxel
NIPPLES = {"left": (75.0, -60.0, -10.0), "right": (-65.0, -60.0, 10.0)}
RADIUS = 50.0  # of both breasts


def two_breasts(spacing: float | tuple[float, float, float] = H) -> LabelMap:
    """Two cones of fat on a slab of fat, muscle and rib cage whose front is at y = 0 mm."""
    grid = grid_around(np.array([-150.0, -80.0, -120.0]), np.array([150.0, 60.0, 120.0]), spacing)
    p = grid.centres().reshape(*grid.shape, 3)
    x, y, z = np.moveaxis(p, -1, 0)
    values = np.zeros(grid.shape, np.uint8)
    across = np.abs(x - 5) < 130
    values[across & (y > 0)] = Label.ADIPOSE
    for nx, ny, nz in NIPPLES.values():
        values[np.hypot(x - nx, z - nz) < RADIUS * (y - ny) / -ny * (y <= 0)] = Label.ADIPOSE
    values[across & (y > 10)] = Label.MUSCLE
    values[across & (y > 20)] = Label.THORAX
    return LabelMap(grid, values)


@pytest.fixture(scope="module")
def labels():
    return two_breasts()


def test_nipples_are_the_tips_farthest_from_the_rib_cage(labels):
    found = nipples(labels)
    for side, place in NIPPLES.items():
        assert np.abs(found.point(f"nipple_{side}") - place).max() < 1.5 * H


def lone(labels: LabelMap, side: str) -> LabelMap:
    """One breast and what is behind it."""
    x = labels.grid.centres().reshape(*labels.grid.shape, 3)[..., 0]
    return replace(labels, values=np.where(np.abs(x - NIPPLES[side][0]) < 55, labels.values, np.uint8(0)))


@pytest.mark.parametrize("side", ["left", "right"])
def test_a_lone_breast_has_one_nipple_on_its_side_and_is_cut_as_both_are(labels, side):
    """Cut beside it, the body's middle is hers, and both halves of it have a tip."""
    found = nipples(lone(labels, side))
    assert found.names == (f"nipple_{side}",)
    assert np.abs(found.points[0] - NIPPLES[side]).max() < 1.5 * H
    low, high = chest_limits(lone(labels, side), found)
    z, wide = NIPPLES[side][2], RADIUS * 5 / 6 + 20
    assert (low[2], high[2]) == pytest.approx((z - wide, z + wide), abs=1.5 * H)
    assert -20 < low[1] == high[1] <= H, "the skin at its edge"
    inward = -1 if side == "left" else 1
    assert low[0] == high[0] == pytest.approx(NIPPLES[side][0] + inward * 45, abs=1.5 * H), "medial"


def test_a_body_with_one_breast_has_one_nipple(labels):
    x, y, _ = np.moveaxis(labels.grid.centres().reshape(*labels.grid.shape, 3), -1, 0)
    flat = replace(labels, values=np.where((x > 5) & (y < 20), np.uint8(0), labels.values))
    assert nipples(flat).names == ("nipple_right",)


def test_a_lone_breast_in_the_middle_of_the_frame_may_be_either(labels):
    moved = replace(labels.grid, origin=labels.grid.origin - [NIPPLES["left"][0], 0, 0])
    with pytest.raises(
        FiducialError, match=r"one breast, and at x = -?\d mm it may be either; list nipple_left or"
    ):
        nipples(replace(lone(labels, "left"), grid=moved))


def test_markers_on_the_skin_are_no_part_of_the_body(labels):
    values = labels.values.copy()
    values[tuple(np.rint(labels.grid.indices(np.array([[40.0, -70.0, 50.0]]))[0]).astype(int))] = Label.MARKER
    assert nipples(replace(labels, values=values)).points.tolist() == nipples(labels).points.tolist()


def test_the_depth_of_the_chest_is_where_its_midline_is_foremost(labels):
    """As of four markers, of which the foremost decides."""
    x, y, z = np.moveaxis(labels.grid.centres().reshape(*labels.grid.shape, 3), -1, 0)
    ridge = (np.abs(x - 5) < 16) & (y > -20) & (z > 20) & (labels.values == Label.AIR)
    higher = replace(labels, values=np.where(ridge & (y < 0), np.uint8(Label.ADIPOSE), labels.values))
    low, high = chest_limits(higher, nipples(labels))
    assert low[1] == high[1] == pytest.approx(-20, abs=H)


def test_the_chest_is_cut_beyond_the_slices_in_which_a_breast_stands_out(labels):
    """10 mm of protrusion are left where the cone of 60 mm is 5/6 of its radius wide; 20 mm more are kept."""
    low, high = chest_limits(labels, nipples(labels))
    wide = RADIUS * 5 / 6 + 20
    assert (low[2], high[2]) == pytest.approx((-10 - wide, 10 + wide), abs=1.5 * H)
    assert low[1] == high[1] == pytest.approx(0.0, abs=H), "the skin of the midline"


def round_ribs(labels: LabelMap) -> LabelMap:
    """The rib cage as a cylinder: tissue beside it is not far from it, though far in front of its middle."""
    p = labels.grid.centres().reshape(*labels.grid.shape, 3)
    ribs = np.hypot(p[..., 0] - 5, p[..., 1] - 120) < 100
    soft = np.where(labels.values == Label.THORAX, np.uint8(Label.ADIPOSE), labels.values)
    return replace(labels, values=np.where(ribs & (soft > 0), np.uint8(Label.THORAX), soft))


def test_voxels_that_are_no_cubes_change_nothing():
    flat = round_ribs(two_breasts((H / 2, H, 2 * H)))
    found = nipples(flat)
    for side, place in NIPPLES.items():
        assert np.abs(found.point(f"nipple_{side}") - place).max() < 1.5 * 2 * H
    low, high = chest_limits(flat, found)
    wide = RADIUS * 5 / 6 + 20
    assert (low[2], high[2]) == pytest.approx((-10 - wide, 10 + wide), abs=1.5 * 2 * H)


def test_labels_without_rib_cage_or_breasts_say_what_to_mark(labels):
    air = LabelMap(labels.grid, np.where(labels.values == Label.THORAX, np.uint8(0), labels.values))
    with pytest.raises(FiducialError, match=r"thorax \(5\).*list nipple_left and nipple_right"):
        nipples(air)
    y = labels.grid.centres().reshape(*labels.grid.shape, 3)[..., 1]
    flat = LabelMap(labels.grid, np.where(y < 0, np.uint8(0), labels.values))
    with pytest.raises(FiducialError, match=r"no breast stands out.*list chest_1 to chest_4"):
        chest_limits(flat, nipples(labels))


def test_the_outline_is_judged_as_an_image_is(labels):
    outline, gravity = outline_image(labels), np.array([0.0, -1.0, 0.0])
    require_usable(outline, position="prone", gravity=gravity)
    front = labels.values[:, labels.values.any(axis=(0, 2)).argmax() + 3 :]
    with pytest.raises(ImageError, match="cuts the breast off"):
        require_usable(
            outline_image(LabelMap(replace(labels.grid, shape=front.shape), front)),
            position="prone",
            gravity=gravity,
        )


def chain_of_labels(path: str, codes: str = "") -> Chain:
    """The chain of a woman of whom there is a label map, and nothing else."""
    subject = Subject("left", "0 -1 0", (1,), moves=False, has=("labels",))
    settings = {
        "registration": {"chest_markers": "found"},
        "labels": {"glandularity_percent": 20.0, "codes": codes},
    }
    return Chain(subject, settings, frozenset(), STAGES).kept({"given_labels": {"labels": path}})


def test_given_labels_are_the_labels_of_the_chain_and_nipples_follow(labels, tmp_path):
    path = str(tmp_path / "labels.nii.gz")
    write_labels(labels, path)
    chain = chain_of_labels(path)
    breast = chain["breast"]
    assert np.array_equal(breast.labels.values, labels.values)
    assert breast.labels.grid.same_as(labels.grid)
    assert breast.nipple == pytest.approx(nipples(labels).point("nipple_left"), abs=1e-3)
    assert breast.gravity.tolist() == [0.0, -1.0, 0.0], "her own frame"
    assert "segmentation" not in chain.upstream("breast")
    assert "registration" not in chain.upstream("breast")


def test_a_file_of_other_labels_is_rejected_by_its_name(labels, tmp_path):
    path = str(tmp_path / "labels.nii.gz")
    write_labels(LabelMap(labels.grid, np.where(labels.values == 5, np.uint8(50), labels.values)), path)
    with pytest.raises(
        ImageError, match=r"labels\.nii\.gz: mammosim has no tissue for code 50 of 0, 1, 4, 50"
    ):
        chain_of_labels(path)["labels"]
    table = tmp_path / "codes.tsv"
    names = {0: "air", 1: "adipose", 4: "muscle", 50: "thorax"}
    table.write_text("code\ttissue\n" + "".join(f"{code}\t{tissue}\n" for code, tissue in names.items()))
    assert np.array_equal(chain_of_labels(path, str(table))["labels"].values, labels.values)
