"""A person's label map: rejected in one line where it cannot be meant, and what is mended is said."""

from dataclasses import replace

import numpy as np
import pytest

from mammosim.chain.given_labels import LabelSettings, Prepared, prepared
from mammosim.chain.label_geometry import filled_in
from mammosim.core.errors import ImageError
from mammosim.core.labels import DEFORMABLE, Label
from mammosim.core.volume import Grid, LabelMap, grid_around
from mammosim.io.label_maps import CodedMap
from mammosim.meshing.body import ElementSize, mesh_body, thin_volume
from mammosim.meshing.quality import quality

H = 4.0  # mm, of a voxel
CM3 = H**3 / 1000  # of a voxel
SETTINGS = LabelSettings(20.0)
A, F, G, S, M, T = (int(label) for label in list(Label)[:6])


def breasts() -> CodedMap:
    """Two half ellipsoids of fat with gland in them on fat, muscle and chest; the back is cut at y = 40."""
    grid = grid_around(np.array([-120.0, -72.0, -60.0]), np.array([120.0, 60.0, 60.0]), H)
    x, y, z = np.moveaxis(grid.centres().reshape(*grid.shape, 3), -1, 0)
    r = np.sqrt(((np.abs(x) - 60) / 44) ** 2 + (y / 60) ** 2 + (z / 44) ** 2)
    values = np.where((y < 40) & ((y > 0) | (r < 1)), F, A)
    values[(r < 0.5) & (y < 12)] = G
    values[(y > 12) & (y < 40)] = M
    values[(y > 24) & (y < 40)] = T
    return CodedMap(grid, values.astype(np.int32), "mine.nii")


def where(coded: CodedMap) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """x, y, z of the voxels."""
    return tuple(np.moveaxis(coded.grid.centres().reshape(*coded.grid.shape, 3), -1, 0))


def changed(mask, code: int, coded: CodedMap | None = None) -> CodedMap:
    coded = coded or breasts()
    return replace(coded, codes=np.where(mask, code, coded.codes))


def taken(coded: CodedMap, codes: str = "", glandularity_percent: float = 20.0) -> Prepared:
    return prepared(coded, LabelSettings(glandularity_percent, codes))


def codes_without_chest(coded: CodedMap) -> CodedMap:
    """Thorax and air have one code."""
    return replace(coded, codes=np.where(coded.codes == T, A, coded.codes))


def test_good_labels_stay_as_they_are():
    found = taken(breasts())
    assert np.array_equal(found.labels.values, breasts().codes)
    assert [note.partition(":")[0] for note in found.notes] == ["no skin is labelled"]


def test_that_segments_overlap_is_said_first():
    (note, *_) = taken(replace(breasts(), overlapping=250)).notes
    assert note == f"{250 * CM3:.2g} cm3 (250 voxels) lie in several segments: the smallest one is kept"


def test_air_behind_the_tissue_is_chest_which_holds_it():
    """What the map calls air behind the muscle is the chest again."""
    found = taken(codes_without_chest(breasts()))
    _x, y, _z = where(breasts())
    assert (found.labels.values[(y > 24)] == T).all()
    assert np.array_equal(found.labels.values[y < 24], breasts().codes[y < 24])
    assert any("cm3 behind the tissue are taken as chest" in note for note in found.notes)


def test_the_rear_of_such_a_mesh_is_held():
    mesh = mesh_body(taken(codes_without_chest(breasts())).labels, size=ElementSize(16.0, 20.0))

    def rear(name: str) -> float:
        corners = mesh.points[mesh.boundaries[name][:, :3]]
        n = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
        return float(np.linalg.norm(n[n[:, 1] > 0.9 * np.linalg.norm(n, axis=1)], axis=1).sum())

    assert rear("posterior") > 0.8 * 240 * 120
    assert rear("skin") < 0.01 * rear("posterior"), "the hanging breasts have no back of their own"


def test_what_hangs_over_beside_its_base_has_a_free_back_with_skin_and_without():
    """A roof of 12 mm beyond the base, 20 mm in front of the chest: the air behind it is air."""
    x, y, z = where(breasts())
    roof = (x > 100) & (x < 116) & (y > -24) & (y < -8) & (np.abs(z) < 30)
    body = changed((x > 100) & (y < 40), A, codes_without_chest(breasts()))
    for coded in (changed(roof, F, body), changed(roof & (y > -12), S, changed(roof, F, body))):
        found = taken(coded).labels.values
        assert (found[(x > 104) & (y > -8)] == A).all()
        assert (found[(x < 100) & (y > 24) & (np.abs(z) < 30)] == T).all()


def test_holes_are_filled_and_strays_dropped_with_their_volumes():
    coded = breasts()
    k, j, i = (int(n) for n in np.rint(coded.grid.indices(np.array([[60.0, -20.0, 0.0]]))[0]))
    codes = coded.codes.copy()
    codes[k, j, i : i + 3] = A  # in the gland
    codes[2, 2, 2] = codes[2, 2, -3] = F
    found = taken(replace(coded, codes=codes))
    assert np.array_equal(found.labels.values, coded.codes)
    assert f"{3 * CM3:.2g} cm3 in 1 holes are filled with the nearest tissue" in found.notes
    assert f"{2 * CM3:.2g} cm3 in 2 stray pieces of tissue are dropped" in found.notes


def test_pieces_beside_each_other_take_their_own_neighbours():
    """A long hole whose box holds a small one: each voxel becomes as its nearest neighbour."""
    grid = grid_around(np.zeros(3), np.array([9.0, 9.0, 1.0]), 1.0)
    values = np.full(grid.shape, F, np.uint8)
    values[0, :, 5:] = G
    unknown = np.zeros(grid.shape, bool)
    unknown[0, 1:8, 1] = unknown[0, 7, 1:8] = unknown[0, 2:4, 7] = True
    found = filled_in(LabelMap(grid, np.where(unknown, np.uint8(0), values)), unknown).values
    assert np.array_equal(found, values)


def test_two_breasts_that_nothing_joins_are_both_meshed():
    x, y, _ = where(breasts())
    found = taken(changed((np.abs(x) < 12) & (y < 24), A))
    assert "is not connected to the rest, and is held by itself" in found.notes[0]
    mesh = mesh_body(found.labels, size=ElementSize(16.0, 20.0))
    volume = np.isin(found.labels.values, DEFORMABLE).sum() * H**3
    assert quality(mesh).volume_mm3.sum() == pytest.approx(volume, rel=0.005)
    assert mesh.points[:, 0].min() < -100 < 100 < mesh.points[:, 0].max()


def test_three_pieces_are_rejected():
    x, y, _z = where(breasts())
    apart = (np.abs(x) < 12) & (y < 24)
    coded = changed((np.abs(np.abs(x) - 60) < 6) & (y < 24), A, changed(apart, A))
    with pytest.raises(
        ImageError, match=r"mine\.nii: the tissue falls into 4 pieces of [0-9, ]+ cm3 that do not touch"
    ):
        taken(coded)


def test_every_second_voxel_is_no_tissue():
    odd = (np.indices(breasts().codes.shape).sum(axis=0) % 2 == 0) & (breasts().codes == F)
    with pytest.raises(ImageError, match=r"\d\d % of the voxels of tissue have no neighbour of tissue"):
        taken(changed(odd, A))


def test_a_breast_on_the_front_border_is_cut_off_and_one_beside_it_is_doubted():
    coded = breasts()
    front = np.isin(coded.codes, (F, G)).any(axis=(0, 2)).argmax()
    near, cut = (
        CodedMap(replace(coded.grid, shape=rows.shape), rows, "mine.nii")
        for rows in (coded.codes[:, front - 1 :], coded.codes[:, front + 1 :])
    )
    assert any("one voxel behind the front border" in note for note in taken(near).notes)
    with pytest.raises(ImageError, match=r"cut off at the front border, where \d+ mm2 of tissue touch it"):
        taken(cut)


@pytest.mark.parametrize(("n", "cut"), [(8, False), (9, True)])
def test_more_than_50_mm2_of_tissue_on_the_front_border_is_a_breast_that_is_cut_off(n, cut):
    """Of voxels of 2 x 3 mm, 5 mm deep."""
    grid = Grid((12, 10, 14), np.array([2.0, 5.0, 3.0]), np.zeros(3))
    codes = np.full(grid.shape, F, np.int32)
    codes[:, 7:] = T
    codes[:, 0] = A
    codes[5, 0, :n] = F
    coded = CodedMap(grid, codes, "mine.nii")
    if not cut:
        assert (taken(coded).labels.values[5, 0, :n] == F).all()
        return
    with pytest.raises(ImageError, match=r"cut off at the front border, where 54 mm2 of tissue touch it"):
        taken(coded)


def test_lesions_are_gland_and_what_is_to_be_ignored_is_as_its_neighbour(tmp_path):
    x, y, z = where(breasts())
    ball = (x - 60) ** 2 + (y + 14) ** 2 + z**2 < 64  # inside the gland
    table = tmp_path / "codes.tsv"
    table.write_text(
        "code\ttissue\n" + "".join(f"{int(label)}\t{label.tissue}\n" for label in Label) + "99\tignore\n"
    )
    found = taken(changed(ball, int(Label.LESION)))
    assert np.array_equal(found.labels.values, breasts().codes)
    assert f"{np.count_nonzero(ball) * CM3:.2g} cm3 of lesions are taken as gland" in found.notes
    assert np.array_equal(taken(changed(ball, 99), str(table)).labels.values, breasts().codes)


def test_codes_of_something_else_are_doubted_where_the_chest_would_lie_inside_the_breast():
    """Published maps have the lesion as 5, which here is the thorax."""
    x, y, z = where(breasts())
    ball = (x - 60) ** 2 + (y + 20) ** 2 + z**2 < 100
    lesion = changed(ball, T, codes_without_chest(breasts()))
    with pytest.raises(
        ImageError, match=r"labelled as thorax lies inside the breast.*fits preset .*pelicano_recoded"
    ):
        taken(lesion)
    assert (taken(lesion, "pelicano_recoded").labels.values[ball] == G).all()


def published(coded: CodedMap) -> CodedMap:
    """As in the repository of Pelicano: fat and gland share a code, thorax and air, too."""
    codes = {A: 0, F: 1, G: 1, S: -2, M: -1, T: 0}
    return replace(coded, codes=np.vectorize(codes.get)(coded.codes).astype(np.int32))


def test_where_fat_and_gland_share_a_code_the_stated_share_of_each_breast_is_gland_in_its_depth():
    found = taken(published(breasts()), "pelicano_simple", 30.0)
    x, y, _z = where(breasts())
    for half in (x < 0, x > 0):
        breast = half & (y < 0) & np.isin(breasts().codes, (F, G))
        gland = half & (found.labels.values == G)
        assert gland[breast].sum() == gland.sum(), "in what stands out"
        assert gland.sum() / breast.sum() == pytest.approx(0.3, abs=0.08), (
            "shells of equal depth are not divided"
        )
    assert any(
        "fat and gland share a code: the innermost 30 % of each breast" in note for note in found.notes
    )
    assert (found.labels.values == M).sum() == (breasts().codes == M).sum()


def test_the_stated_share_is_of_each_breast_however_unlike_they_are():
    x, y, z = where(breasts())
    r = np.sqrt(((np.abs(x) - 60) / 44) ** 2 + (y / 60) ** 2 + (z / 44) ** 2)
    small = changed((x > 0) & (y < 0) & (r > 0.6), A)
    found = taken(published(small), "pelicano_simple", 30.0)
    for half in (x < 0, x > 0):
        breast = half & (y < 0) & np.isin(small.codes, (F, G))
        gland = half & (found.labels.values == G)
        assert gland.sum() / breast.sum() == pytest.approx(0.3, abs=0.1)


def test_a_marker_inside_the_breast_is_a_code_of_something_else():
    x, y, z = where(breasts())
    ball = (x - 60) ** 2 + (y + 20) ** 2 + z**2 < 100
    with pytest.raises(
        ImageError, match=r"marker lies inside the breast, where there is none; correct it; if the codes"
    ):
        taken(changed(ball, int(Label.MARKER)))


def test_a_breast_around_labelled_gland_is_fat():
    """Segments of a whole breast and of its dense tissue."""
    coded = breasts()
    segments = [
        ("FGT", coded.codes == G),
        ("breast", np.isin(coded.codes, (F, G))),
        ("chest wall", coded.codes == T),
    ]
    found = prepared(CodedMap.of_segments(coded.grid, segments, "mine.seg.nrrd"), SETTINGS)
    soft = np.isin(coded.codes, (F, G))
    assert np.array_equal(found.labels.values[soft], coded.codes[soft])
    assert "no muscle is labelled: the chest holds what lies on it" in found.notes


def test_labels_of_no_breast_are_rejected_with_what_they_may_be():
    with pytest.raises(
        ImageError, match=r"mine\.nii: no voxel is labelled as adipose or glandular; .*; if the codes are"
    ):
        taken(changed(True, A))


def test_skin_of_the_map_counts_as_fat_and_that_is_said():
    """The mesh has a membrane of the skin's own thickness, whatever voxels can show."""
    coded = breasts()
    air = np.pad(coded.codes, 1, mode="edge") == A
    near = np.any([np.roll(air, n, axis)[1:-1, 1:-1, 1:-1] for axis in range(3) for n in (1, -1)], axis=0)
    skin = near & (coded.codes == F)
    found = taken(changed(skin, S))
    assert f"{np.count_nonzero(skin) * CM3:.0f} cm3 of skin count as fat under a membrane" in found.notes[0]


def test_what_is_thinner_than_half_an_element_is_measured():
    coded = breasts()
    x, y, z = where(coded)
    sheet = (np.abs(x) < 16) & (y < 0) & (y > -40) & (np.abs(z - 2) < 2) & (coded.codes == A)
    labels, more = (
        LabelMap(coded.grid, each.codes.astype(np.uint8)) for each in (coded, changed(sheet, F, coded))
    )
    size = ElementSize(10.0, 10.0)
    thicker = thin_volume(more, size) - thin_volume(labels, size)
    assert thicker == pytest.approx(np.count_nonzero(sheet) * H**3, rel=0.15)
